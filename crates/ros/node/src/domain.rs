//! The DDS domain and the discovery range of a node, from environment variables of ROS.

use crate::error::{Error, Result};
use std::net::{Ipv4Addr, SocketAddr, ToSocketAddrs as _};

/// Highest domain id whose ports are below 65536.
const HIGHEST: u16 = 232;

/// Maximum number of static peers: each is contacted once a second, at the ports of 32 participants.
const MAX_PEERS: usize = 256;

/// Domain and networks of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Domain {
    /// `ROS_DOMAIN_ID`, 0 to 232.
    pub id: u16,
    /// Whether only peers on this machine are used, over the loopback interface.
    pub local: bool,
}

impl Domain {
    /// Reads `ROS_DOMAIN_ID`, `ROS_AUTOMATIC_DISCOVERY_RANGE` and `ROS_LOCALHOST_ONLY`.
    ///
    /// # Errors
    /// A variable has a value that ROS does not define, or a range that is not supported here.
    pub fn from_environment() -> Result<Self> {
        Self::from_variables(|name| std::env::var(name).ok())
    }

    fn from_variables(variable: impl Fn(&str) -> Option<String>) -> Result<Self> {
        let given = |name: &str| variable(name).filter(|text| !text.is_empty());
        let id = match given("ROS_DOMAIN_ID") {
            None => 0,
            Some(text) => match text.parse() {
                Ok(id) if id <= HIGHEST => id,
                _ => {
                    let expected = format!("a number from 0 to {HIGHEST} is expected");
                    return Err(Error::environment(
                        format!("ROS_DOMAIN_ID='{text}'"),
                        expected,
                    ));
                }
            },
        };
        let range = given("ROS_AUTOMATIC_DISCOVERY_RANGE").unwrap_or_default();
        let mut local = match range.as_str() {
            "" | "SUBNET" | "SYSTEM_DEFAULT" => false,
            "LOCALHOST" => true,
            "OFF" => {
                return Err(Error::environment(
                    "ROS_AUTOMATIC_DISCOVERY_RANGE=OFF",
                    "with OFF, nodes do not discover each other, not even static peers. Use LOCALHOST or SUBNET",
                ));
            }
            other => {
                return Err(Error::environment(
                    format!("ROS_AUTOMATIC_DISCOVERY_RANGE='{other}'"),
                    "LOCALHOST, SUBNET, OFF or SYSTEM_DEFAULT is expected",
                ));
            }
        };
        // Deprecated, and above the range where it is set, as in Jazzy.
        if let Some(text) = given("ROS_LOCALHOST_ONLY") {
            local |= match text.as_str() {
                "0" => false,
                "1" => true,
                _ => {
                    let variable = format!("ROS_LOCALHOST_ONLY='{text}'");
                    return Err(Error::environment(variable, "0 or 1 is expected"));
                }
            };
        }
        Ok(Self { id, local })
    }
}

/// The addresses in `ROS_STATIC_PEERS`, separated by semicolons. Discovery contacts them by unicast, for networks without multicast. Names are
/// resolved once, at the start; all addresses of a name are used.
///
/// # Errors
/// An entry that is neither an IPv4 address nor a name of one, or more than [`MAX_PEERS`] addresses.
pub(crate) fn static_peers(variable: impl Fn(&str) -> Option<String>) -> Result<Vec<Ipv4Addr>> {
    let text = variable("ROS_STATIC_PEERS").unwrap_or_default();
    let mut peers = Vec::new();
    for entry in text.split(';').map(str::trim).filter(|e| !e.is_empty()) {
        let refused = |reason: String| Error::environment("ROS_STATIC_PEERS", reason);
        let found = (entry, 0)
            .to_socket_addrs()
            .map_err(|reason| refused(format!("'{entry}': {reason}")))?;
        let found: Vec<Ipv4Addr> = found
            .filter_map(|address| match address {
                SocketAddr::V4(address) => Some(*address.ip()),
                SocketAddr::V6(_) => None,
            })
            .collect();
        if found.is_empty() {
            return Err(refused(format!(
                "'{entry}' has no IPv4 address; only IPv4 is supported"
            )));
        }
        for address in found {
            if !peers.contains(&address) {
                peers.push(address);
            }
        }
        if peers.len() > MAX_PEERS {
            return Err(refused(format!(
                "more than {MAX_PEERS} addresses are listed. List only addresses of machines that run nodes"
            )));
        }
    }
    Ok(peers)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn domain(variables: &[(&str, &str)]) -> Result<Domain> {
        Domain::from_variables(|name| {
            let found = variables.iter().find(|(n, _)| *n == name)?;
            Some(found.1.to_owned())
        })
    }

    #[test]
    fn the_variables_mean_what_ros_says() {
        for (variables, id, local) in [
            (vec![], 0, false),
            (vec![("ROS_DOMAIN_ID", "42")], 42, false),
            (vec![("ROS_DOMAIN_ID", "")], 0, false),
            (
                vec![("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")],
                0,
                true,
            ),
            (vec![("ROS_LOCALHOST_ONLY", "1")], 0, true),
        ] {
            let found = domain(&variables).expect("good variables");
            assert_eq!(found, Domain { id, local }, "{variables:?}");
        }
    }

    #[test]
    fn static_peers_are_addresses_or_names_between_semicolons() {
        let peers = |text: &str| static_peers(|_| Some(text.to_owned()));
        for (text, found) in [
            ("", vec![]),
            (";", vec![]),
            ("192.168.0.7", vec![[192, 168, 0, 7]]),
            (" 10.0.0.1 ;127.0.0.1;", vec![[10, 0, 0, 1], [127, 0, 0, 1]]),
            ("localhost", vec![[127, 0, 0, 1]]),
            ("127.0.0.1;127.0.0.1", vec![[127, 0, 0, 1]]),
        ] {
            let found: Vec<Ipv4Addr> = found.into_iter().map(Ipv4Addr::from).collect();
            assert_eq!(peers(text).expect("good peers"), found, "{text}");
        }
        let refusal = peers("127.0.0.1;::1").expect_err("no IPv4").to_string();
        assert!(refusal.contains("'::1'"), "{refusal}");

        let all: Vec<String> = (0..256).map(|host| format!("10.0.0.{host}")).collect();
        assert_eq!(peers(&all.join(";")).expect("as many").len(), MAX_PEERS);
        let refusal = peers(&format!("{};10.0.1.0", all.join(";"))).expect_err("one more");
        assert!(refusal.to_string().contains("more than 256"), "{refusal}");
    }

    #[test]
    fn what_ros_does_not_define_is_refused() {
        for (name, value) in [
            ("ROS_DOMAIN_ID", "233"),
            ("ROS_DOMAIN_ID", "-1"),
            ("ROS_DOMAIN_ID", "zero"),
            ("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF"),
            ("ROS_AUTOMATIC_DISCOVERY_RANGE", "localhost"),
            ("ROS_LOCALHOST_ONLY", "yes"),
        ] {
            let refusal = domain(&[(name, value)]).expect_err(name).to_string();
            assert!(refusal.contains(name), "{refusal}");
        }
    }
}
