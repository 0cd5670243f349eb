//! `planesman doctor`: checks whether nodes discover each other on this machine; if they do not, prints what to do.

use std::net::{Ipv4Addr, UdpSocket};
use std::path::Path;
use std::time::Duration;

use anyhow::{Context as _, Result, bail};
use planesman_msgs::planesman_msgs::msg::VehicleState;
use planesman_node::{Domain, NodeSpec, Qos, Runtime, args};

use crate::dive::find_no_other_loop;
use planesman_console::{Outcome, wrapped};

/// Multicast address of DDS discovery.
const GROUP: Ipv4Addr = Ipv4Addr::new(239, 255, 0, 1);

/// Marker file of the installed message package, below a prefix in `AMENT_PREFIX_PATH`.
const MESSAGES: &str = "share/ament_index/resource_index/packages/planesman_msgs";

/// Prints one line per check, and whether dives work here.
///
/// # Errors
/// A check failed; the error says what to do.
pub fn run(namespace: &str) -> Result<()> {
    let mut to_do = Vec::new();
    let mut tell = |what: &str, found: Result<String>| -> std::io::Result<()> {
        match found {
            Ok(text) => line(&format!("ok       {what}: {text}")),
            Err(error) => {
                to_do.push(format!("{error:#}"));
                line(&format!("TROUBLE  {what}"))
            }
        }
    };
    let domain = Domain::from_environment();
    let local = domain.as_ref().is_ok_and(|domain| domain.local);
    tell(
        "domain and range",
        domain.map(described).map_err(Into::into),
    )?;
    tell(
        "middleware",
        middleware(std::env::var("RMW_IMPLEMENTATION").ok()),
    )?;
    tell("multicast", multicast(local))?;
    tell("other loops", others(namespace))?;
    let prefixes = std::env::var_os("AMENT_PREFIX_PATH").unwrap_or_default();
    let installed = std::env::split_paths(&prefixes).find(|prefix| prefix.join(MESSAGES).is_file());
    line(&messages(installed.as_deref()))?;
    if !to_do.is_empty() {
        bail!("dives do NOT work here: {}", to_do.join("; "));
    }
    planesman_console::print("\n")?;
    let ready = Outcome::new("Ready: dives work here.");
    Ok(ready.next("planesman", "fly the built-in dive").print()?)
}

fn line(text: &str) -> std::io::Result<()> {
    planesman_console::out!("{}", wrapped(text).trim_end())
}

fn described(domain: Domain) -> String {
    let range = if domain.local {
        "LOCALHOST: only nodes on this machine"
    } else {
        "SUBNET: nodes on all machines of the subnet"
    };
    format!("ROS_DOMAIN_ID {}, discovery range {range}", domain.id)
}

/// The middleware that `RMW_IMPLEMENTATION` names. The RMW implementation decides the form in which the nodes send services.
fn middleware(named: Option<String>) -> Result<String> {
    match named.as_deref() {
        None | Some("") => Ok("rmw_fastrtps_cpp, Jazzy's default".to_owned()),
        Some(
            name @ ("rmw_fastrtps_cpp"
            | "rmw_fastrtps_dynamic_cpp"
            | "rmw_connextdds"
            | "rmw_cyclonedds_cpp"),
        ) => Ok(name.to_owned()),
        Some(other) => bail!(
            "RMW_IMPLEMENTATION='{other}' is not supported, because the nodes use DDS. Unset it, or set it to rmw_fastrtps_cpp or \
             rmw_cyclonedds_cpp"
        ),
    }
}

/// Sends a datagram to the multicast group and receives it again, on the interface that the nodes use.
fn multicast(local: bool) -> Result<String> {
    let (interface, name) = if local {
        (Ipv4Addr::LOCALHOST, "the loopback interface")
    } else {
        (Ipv4Addr::UNSPECIFIED, "the default interface")
    };
    let arrived = || -> std::io::Result<()> {
        let listener = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0))?;
        listener.join_multicast_v4(&GROUP, &interface)?;
        listener.set_read_timeout(Some(Duration::from_secs(1)))?;
        let speaker = UdpSocket::bind((interface, 0))?;
        speaker.send_to(b"planesman", (GROUP, listener.local_addr()?.port()))?;
        listener.recv(&mut [0; 16]).map(drop)
    };
    arrived().with_context(|| {
        format!(
            "no datagram sent to {GROUP} came back on {name}. Allow multicast there (ip link set DEVICE multicast on, \
             a route for 224.0.0.0/4, the firewall)"
        )
    })?;
    Ok(format!("a datagram sent to {GROUP} came back on {name}"))
}

/// Fails if another loop runs in the namespace.
fn others(namespace: &str) -> Result<String> {
    let remap = format!("__ns:={namespace}");
    let (rt, ()) = Runtime::start(
        NodeSpec {
            name: "planesman_doctor",
            namespace: "/auv",
            validate: |(): &()| Ok(()),
            on_parameters: |_| (),
        },
        args::only(["--ros-args", "-r", &remap, "--log-level", "warn"].map(str::to_owned))?,
    )?;
    rt.subscribe("state", Qos::reliable(10), |_: VehicleState| ())?;
    find_no_other_loop(&rt, || Ok(()))?;
    Ok(format!("none in namespace {namespace}"))
}

/// Whether the message package is installed, which `ros2` needs to show the loop's own messages.
fn messages(installed: Option<&Path>) -> String {
    match installed {
        Some(prefix) => format!("ok       planesman_msgs: in {}", prefix.display()),
        None => "note     planesman_msgs: not found in AMENT_PREFIX_PATH; ros2 topic echo shows only standard messages \
                 there. Build it: colcon build --packages-select planesman_msgs, then source install/setup.bash"
            .to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_middleware_that_is_no_dds_is_a_trouble_with_its_remedy() {
        for good in ["", "rmw_fastrtps_cpp", "rmw_cyclonedds_cpp"] {
            assert!(middleware(Some(good.to_owned())).is_ok(), "{good}");
        }
        let trouble = middleware(Some("rmw_zenoh_cpp".to_owned())).expect_err("no DDS");
        assert!(trouble.to_string().contains("Unset it"), "{trouble}");
    }

    #[test]
    fn multicast_comes_back_on_the_loopback_interface() {
        let found = multicast(true).expect("the tests' nodes find each other so");
        assert!(found.contains("loopback"), "{found}");
    }
}
