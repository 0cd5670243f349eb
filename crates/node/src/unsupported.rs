//! Variables of ROS that ask for what these nodes do not have: refused, or told, never passed over.

use anyhow::bail;

/// What is to be told, as sentences.
///
/// # Errors
/// When security is to be enforced: a node that ignored it would speak in the clear.
pub(crate) fn check(variable: impl Fn(&str) -> Option<String>) -> anyhow::Result<Vec<String>> {
    let mut told = Vec::new();
    // As rcl reads them: both count only as they are written here.
    if variable("ROS_SECURITY_ENABLE").as_deref() == Some("true") {
        if variable("ROS_SECURITY_STRATEGY").as_deref() == Some("Enforce") {
            bail!(
                "ROS_SECURITY_ENABLE=true, ROS_SECURITY_STRATEGY=Enforce: this node has no DDS security (SROS2) and would \
                 speak in the clear; unset ROS_SECURITY_ENABLE to run it so"
            );
        }
        told.push(
            "ROS_SECURITY_ENABLE=true: this node has no DDS security (SROS2); it speaks in the clear, and anybody \
             on the network can read and command it"
                .to_owned(),
        );
    }
    let peers = variable("ROS_STATIC_PEERS").unwrap_or_default();
    let far: Vec<&str> = peers
        .split(';')
        .map(str::trim)
        .filter(|peer| !peer.is_empty() && !is_here(peer))
        .collect();
    if !far.is_empty() {
        told.push(format!(
            "ROS_STATIC_PEERS: {} not looked for: this node finds others by multicast, and on this machine alone \
             without",
            far.join(", ")
        ));
    }
    Ok(told)
}

/// Whether that address is this machine's, where others are looked for anyway.
fn is_here(peer: &str) -> bool {
    let address: Result<std::net::IpAddr, _> = peer.parse();
    peer == "localhost" || address.is_ok_and(|address| address.is_loopback())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(variables: &[(&str, &str)]) -> anyhow::Result<Vec<String>> {
        check(|name| {
            let found = variables.iter().find(|(n, _)| *n == name)?;
            Some(found.1.to_owned())
        })
    }

    #[test]
    fn enforced_security_is_refused_and_permissive_told() {
        let enable = ("ROS_SECURITY_ENABLE", "true");
        let refusal = told(&[enable, ("ROS_SECURITY_STRATEGY", "Enforce")])
            .expect_err("enforced")
            .to_string();
        assert!(
            refusal.contains("ROS_SECURITY_STRATEGY=Enforce"),
            "{refusal}"
        );
        for strategy in ["", "Permissive", "enforce"] {
            let told = told(&[enable, ("ROS_SECURITY_STRATEGY", strategy)]).expect("not enforced");
            assert!(told[0].contains("in the clear"), "{told:?}");
        }
        assert_eq!(told(&[enable]).expect("not enforced").len(), 1);
    }

    #[test]
    fn security_that_rcl_takes_for_switched_off_is_off_here() {
        let strategy = ("ROS_SECURITY_STRATEGY", "Enforce");
        for off in ["", "false", "True", "1"] {
            let told = told(&[("ROS_SECURITY_ENABLE", off), strategy]).expect("off");
            assert_eq!(told, [""; 0], "{off}");
        }
        assert_eq!(told(&[strategy]).expect("off"), [""; 0]);
    }

    #[test]
    fn peers_that_will_not_be_looked_for_are_named() {
        let peers = |text| told(&[("ROS_STATIC_PEERS", text)]).expect("no security");
        for here in ["", ";", "127.0.0.1;localhost;::1"] {
            assert_eq!(peers(here), [""; 0], "{here}");
        }
        let told = peers("127.0.0.1; 192.168.0.7 ;auv.local");
        assert!(
            told[0].contains("192.168.0.7, auv.local not looked for"),
            "{told:?}"
        );
    }
}
