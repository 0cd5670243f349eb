//! A DDS domain that nobody else on this machine uses, for parallel tests.

use std::{
    env,
    fs::{File, OpenOptions},
    io,
    net::{Ipv4Addr, UdpSocket},
};

use crate::domain::Domain;

/// Domains to choose from: their ports are below the system's ephemeral ports (32768 up).
const CHOICE: std::ops::RangeInclusive<u16> = 1..=100;

/// A domain reserved until the value is dropped or the process ends.
#[derive(Debug)]
pub struct OwnDomain {
    id: u16,
    _lock: File,
}

impl OwnDomain {
    /// Reserves a domain whose discovery port is free and that no other value of this type holds.
    ///
    /// # Errors
    /// Lock files cannot be created, or all domains are in use.
    pub fn claim() -> io::Result<Self> {
        for id in CHOICE {
            let path = env::temp_dir().join(format!("planesman-domain-{id}.lock"));
            let lock = OpenOptions::new()
                .create(true)
                .truncate(false)
                .write(true)
                .open(path)?;
            // The unicast discovery port of a domain's first participant (RTPS 2.3, 9.6.1.1).
            let port = 7400 + 250 * id + 10;
            if lock.try_lock().is_ok() && UdpSocket::bind((Ipv4Addr::LOCALHOST, port)).is_ok() {
                return Ok(Self { id, _lock: lock });
            }
        }
        Err(io::Error::other(
            "every DDS domain of this machine is in use",
        ))
    }

    /// Number of the domain, for `ROS_DOMAIN_ID`.
    #[must_use]
    pub fn id(&self) -> u16 {
        self.id
    }

    /// The domain restricted to this machine, for a node in this process.
    #[must_use]
    pub fn domain(&self) -> Domain {
        Domain {
            id: self.id,
            local: true,
        }
    }

    /// Environment variables that restrict a process to the domain and this machine.
    #[must_use]
    pub fn variables(&self) -> [(&'static str, String); 2] {
        [
            ("ROS_DOMAIN_ID", self.id.to_string()),
            ("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST".to_owned()),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_hold_the_same_domain() {
        let first = OwnDomain::claim().expect("a free domain");
        let second = OwnDomain::claim().expect("a free domain");
        assert_ne!(first.id(), second.id());
    }
}
