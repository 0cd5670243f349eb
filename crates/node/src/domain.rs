//! The DDS domain and the discovery range of a node, from ROS's variables.

use std::net::{IpAddr, Ipv4Addr};

use anyhow::{bail, ensure};

/// The highest domain whose ports fit below 65536.
const HIGHEST: u16 = 232;

/// The domain and the networks a node speaks on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Domain {
    /// `ROS_DOMAIN_ID`, 0 to 232.
    pub id: u16,
    /// Only peers on this machine, over the loopback interface.
    pub local: bool,
}

impl Domain {
    /// As `ROS_DOMAIN_ID`, `ROS_AUTOMATIC_DISCOVERY_RANGE` and `ROS_LOCALHOST_ONLY` say.
    ///
    /// # Errors
    /// When one of them holds something else than ROS defines, or a range not to be had here.
    pub fn from_environment() -> anyhow::Result<Self> {
        Self::from_variables(|name| std::env::var(name).ok())
    }

    fn from_variables(variable: impl Fn(&str) -> Option<String>) -> anyhow::Result<Self> {
        let given = |name: &str| variable(name).filter(|text| !text.is_empty());
        let id = match given("ROS_DOMAIN_ID") {
            None => 0,
            Some(text) => match text.parse() {
                Ok(id) if id <= HIGHEST => id,
                _ => bail!("ROS_DOMAIN_ID='{text}': a number from 0 to {HIGHEST} is expected"),
            },
        };
        let range = given("ROS_AUTOMATIC_DISCOVERY_RANGE").unwrap_or_default();
        let mut local = match range.as_str() {
            "" | "SUBNET" | "SYSTEM_DEFAULT" => false,
            "LOCALHOST" => true,
            "OFF" => bail!(
                "ROS_AUTOMATIC_DISCOVERY_RANGE=OFF: nodes would not find each other, and there \
                 are no static peers here; use LOCALHOST or SUBNET"
            ),
            other => bail!(
                "ROS_AUTOMATIC_DISCOVERY_RANGE='{other}': LOCALHOST, SUBNET, OFF or \
                 SYSTEM_DEFAULT is expected"
            ),
        };
        // Deprecated, and above the range where it is set, as in Jazzy.
        if let Some(text) = given("ROS_LOCALHOST_ONLY") {
            ensure!(
                text == "0" || text == "1",
                "ROS_LOCALHOST_ONLY='{text}': 0 or 1 is expected"
            );
            local |= text == "1";
        }
        Ok(Self { id, local })
    }

    /// The addresses to speak on, `None` for all.
    pub(crate) fn networks(self) -> Option<[IpAddr; 1]> {
        self.local.then_some([IpAddr::V4(Ipv4Addr::LOCALHOST)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn domain(variables: &[(&str, &str)]) -> anyhow::Result<Domain> {
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
