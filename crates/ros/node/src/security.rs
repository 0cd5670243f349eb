//! SROS2: whether a node uses DDS Security, and its enclave.
//!
//! The variables have the meaning of `rcl` (`rcl/security.c`), and the enclave's folder must contain the files that `rmw_dds_common` expects. DDS
//! Security itself is compiled in with the Cargo feature `security` (`docs/security.md`).

use crate::error::{Error, Result};
use rustdds::DomainParticipantBuilder;

/// Files that an enclave's folder must contain.
#[cfg(feature = "security")]
const FILES: [&str; 6] = [
    "identity_ca.cert.pem",
    "cert.pem",
    "key.pem",
    "permissions_ca.cert.pem",
    "governance.p7s",
    "permissions.p7s",
];

/// Security of a node.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Security {
    /// Unencrypted; with a warning if security was requested.
    Clear(Option<String>),
    /// Secured by the files in this folder.
    #[cfg(feature = "security")]
    Enclave(std::path::PathBuf),
}

/// The reason why security is not available.
#[derive(Debug, thiserror::Error)]
enum NoEnclave {
    #[cfg(not(feature = "security"))]
    #[error("DDS security (SROS2) is not compiled in (build with the Cargo feature 'security')")]
    NotBuiltIn,
    #[cfg(feature = "security")]
    #[error("ROS_SECURITY_KEYSTORE does not name a keystore")]
    NoKeystore,
    #[cfg(feature = "security")]
    #[error("the enclave {0}")]
    Name(#[from] crate::bad_argument::BadArgument),
    #[cfg(feature = "security")]
    #[error("{} is not a file", .0.display())]
    NoFile(std::path::PathBuf),
}

impl Security {
    /// Security requested by the variables, for a node in `enclave`.
    ///
    /// # Errors
    /// Security is enforced but not available: the node would otherwise run unencrypted.
    pub(crate) fn asked_for(
        enclave: &str,
        variable: impl Fn(&str) -> Option<String>,
    ) -> Result<Self> {
        // Both count only as they are written here.
        let is = |name: &str, value: &str| variable(name).as_deref() == Some(value);
        if !is("ROS_SECURITY_ENABLE", "true") {
            return Ok(Self::Clear(None));
        }
        match Self::of_enclave(enclave, &variable) {
            Ok(found) => Ok(found),
            Err(why) if is("ROS_SECURITY_STRATEGY", "Enforce") => Err(Error::environment(
                "ROS_SECURITY_ENABLE=true, ROS_SECURITY_STRATEGY=Enforce",
                format!("{why}; to run the node unencrypted, unset ROS_SECURITY_ENABLE"),
            )),
            Err(why) => Ok(Self::Clear(Some(format!(
                "ROS_SECURITY_ENABLE=true: {why}; this node runs unencrypted, and anybody on the network can \
                 read and command it"
            )))),
        }
    }

    #[cfg(not(feature = "security"))]
    fn of_enclave(_: &str, _: impl Fn(&str) -> Option<String>) -> Result<Self, NoEnclave> {
        Err(NoEnclave::NotBuiltIn)
    }

    /// The enclave's folder, if it contains all files.
    #[cfg(feature = "security")]
    fn of_enclave(
        enclave: &str,
        variable: impl Fn(&str) -> Option<String>,
    ) -> Result<Self, NoEnclave> {
        let given = |name| variable(name).filter(|text| !text.is_empty());
        let keystore = given("ROS_SECURITY_KEYSTORE").ok_or(NoEnclave::NoKeystore)?;
        let name = given("ROS_SECURITY_ENCLAVE_OVERRIDE").unwrap_or_else(|| enclave.to_owned());
        crate::name_rules::check_namespace(&name)?;
        let folder = std::path::Path::new(&keystore)
            .join("enclaves")
            .join(name.trim_start_matches('/'));
        match FILES.iter().find(|file| !folder.join(file).is_file()) {
            None => Ok(Self::Enclave(folder)),
            Some(absent) => Err(NoEnclave::NoFile(folder.join(absent))),
        }
    }

    /// Warning if security was requested and is not available.
    pub(crate) fn lack(&self) -> Option<String> {
        match self {
            Self::Clear(warning) => warning.clone(),
            #[cfg(feature = "security")]
            Self::Enclave(_) => None,
        }
    }

    /// Applies the security to a participant.
    pub(crate) fn applied(&self, builder: DomainParticipantBuilder) -> DomainParticipantBuilder {
        match self {
            Self::Clear(_) => builder,
            #[cfg(feature = "security")]
            Self::Enclave(folder) => {
                use rustdds::DomainParticipantSecurityConfigFiles as Files;
                // As sros2 makes them, private keys have no password.
                builder.builtin_security(Files::with_ros_default_names(folder, String::new()))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ENABLE: (&str, &str) = ("ROS_SECURITY_ENABLE", "true");
    const ENFORCE: (&str, &str) = ("ROS_SECURITY_STRATEGY", "Enforce");

    fn asked_for(enclave: &str, variables: &[(&str, &str)]) -> Result<Security> {
        Security::asked_for(enclave, |name| {
            let found = variables.iter().find(|(n, _)| *n == name)?;
            Some(found.1.to_owned())
        })
    }

    #[test]
    fn security_that_cannot_be_had_is_refused_if_enforced_and_told_otherwise() {
        let refusal = asked_for("/", &[ENABLE, ENFORCE])
            .expect_err("enforced")
            .to_string();
        assert!(
            refusal.contains("ROS_SECURITY_STRATEGY=Enforce"),
            "{refusal}"
        );
        for strategy in ["", "Permissive", "enforce"] {
            let asked = asked_for("/", &[ENABLE, ("ROS_SECURITY_STRATEGY", strategy)]);
            let Ok(Security::Clear(Some(warning))) = asked else {
                panic!("{strategy}: {asked:?}")
            };
            assert!(warning.contains("unencrypted"), "{warning:?}");
        }
        let asked = asked_for("/", &[ENABLE]);
        assert!(matches!(asked, Ok(Security::Clear(Some(_)))), "{asked:?}");
    }

    #[test]
    fn security_that_rcl_takes_for_switched_off_is_off_here() {
        for off in ["", "false", "True", "1"] {
            let asked = asked_for("/", &[("ROS_SECURITY_ENABLE", off), ENFORCE]);
            assert_eq!(asked.expect("off"), Security::Clear(None), "{off}");
        }
        assert_eq!(
            asked_for("/", &[ENFORCE]).expect("off"),
            Security::Clear(None)
        );
    }

    #[cfg(not(feature = "security"))]
    #[test]
    fn a_build_without_security_names_the_feature_that_brings_it() {
        let refusal = asked_for("/", &[ENABLE, ENFORCE]).expect_err("enforced");
        assert!(
            refusal.to_string().contains("Cargo feature 'security'"),
            "{refusal}"
        );
    }

    #[cfg(feature = "security")]
    #[test]
    fn the_enclave_is_looked_for_where_rcl_looks_for_it() {
        use std::{fs, path::Path};

        let keystore =
            std::env::temp_dir().join(format!("planesman-keystore-{}", std::process::id()));
        for enclave in ["", "auv/plant_sim"] {
            let folder = keystore.join("enclaves").join(enclave);
            fs::create_dir_all(&folder).expect("a folder");
            for file in FILES {
                fs::write(folder.join(file), "").expect("a file");
            }
        }
        let store = keystore.to_str().expect("a path of UTF-8");
        let given = ("ROS_SECURITY_KEYSTORE", store);
        let found = |enclave: &str, variables: &[_]| match asked_for(
            enclave,
            &[&[ENABLE, ENFORCE, given], variables].concat(),
        ) {
            Ok(Security::Enclave(folder)) => Ok(folder
                .strip_prefix(&keystore)
                .map(Path::to_owned)
                .expect("within it")),
            Ok(clear) => panic!("{clear:?}"),
            Err(refusal) => Err(refusal.to_string()),
        };
        let replaced = |name| [("ROS_SECURITY_ENCLAVE_OVERRIDE", name)];
        let own = Ok(Path::new("enclaves/auv/plant_sim").to_owned());
        assert_eq!(found("/", &[]), Ok("enclaves".into()));
        assert_eq!(found("/auv/plant_sim", &[]), own);
        assert_eq!(found("/auv/plant_sim", &replaced("")), own);
        assert_eq!(found("/", &replaced("/auv/plant_sim")), own);
        for (name, reason) in [
            ("/auv", "identity_ca.cert.pem is not a file"),
            ("/../enclaves", "tokens"),
            ("auv", "slash"),
        ] {
            let refusal = found("/", &replaced(name)).expect_err(name);
            assert!(refusal.contains(reason), "{name}: {refusal}");
        }
        fs::remove_dir_all(&keystore).expect("the folder is gone");
        assert!(asked_for("/", &[ENABLE, ENFORCE]).is_err(), "no keystore");
    }
}
