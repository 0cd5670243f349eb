//! Warnings about features that ROS's variables ask for and these nodes do not have.

/// The warning, as a sentence.
pub(crate) fn check(variable: impl Fn(&str) -> Option<String>) -> Option<String> {
    let peers = variable("ROS_STATIC_PEERS").unwrap_or_default();
    let far: Vec<&str> = peers
        .split(';')
        .map(str::trim)
        .filter(|peer| !peer.is_empty() && !is_here(peer))
        .collect();
    (!far.is_empty()).then(|| {
        format!(
            "ROS_STATIC_PEERS: {} not looked for: this node finds others by multicast, and on this machine alone \
             without",
            far.join(", ")
        )
    })
}

/// Whether that address is this machine's, where others are looked for anyway.
fn is_here(peer: &str) -> bool {
    let address: Result<std::net::IpAddr, _> = peer.parse();
    peer == "localhost" || address.is_ok_and(|address| address.is_loopback())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peers_that_will_not_be_looked_for_are_named() {
        let peers = |text: &str| check(|_| Some(text.to_owned()));
        for here in ["", ";", "127.0.0.1;localhost;::1"] {
            assert_eq!(peers(here), None, "{here}");
        }
        let warning = peers("127.0.0.1; 192.168.0.7 ;auv.local").expect("two are elsewhere");
        assert!(
            warning.contains("192.168.0.7, auv.local not looked for"),
            "{warning}"
        );
    }
}
