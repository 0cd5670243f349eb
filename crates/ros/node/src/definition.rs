//! Definitions of types that others publish: from this project, from an installed package, or described by the publisher's node.

use std::{
    cell::RefCell,
    collections::BTreeMap,
    env,
    path::PathBuf,
    rc::Rc,
    time::{Duration, Instant},
};

use planesman_msgs::{
    description::describe,
    type_description_interfaces::{
        msg::TypeSource,
        srv::{GetTypeDescription, GetTypeDescriptionRequest},
    },
    type_info,
};
use planesman_rosidl::{
    Error, Library, TypeName, definition::Kind, parse_action, parse_message, parse_service,
};

use crate::{
    discovered::{PublishedTopic, describers},
    runtime::{ClientOpener, Runtime},
    service::Client,
};

/// Timeout for a topic's publishers to describe its type.
const DESCRIPTION_TIMEOUT: Duration = Duration::from_secs(2);
/// Interval of looking for nodes that describe types.
const POLL_INTERVAL: Duration = Duration::from_millis(100);
/// Maximum number of nodes asked about a type.
const MAX_DESCRIBERS: usize = 8;

/// Definition of a type with all types it uses, and its hash.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Definition {
    /// Definition as stored in bags (`ros2msg`); empty if it is not known.
    pub text: String,
    /// The hash `RIHS01_...`, computed from the text. For a type without text it is the publisher's hash, or empty.
    pub type_hash: String,
}

/// The reason why a type has no definition.
#[derive(Debug, thiserror::Error)]
pub enum DefinitionError {
    /// Invalid ROS type name.
    #[error("'{0}' is not a type name")]
    Name(String),
    /// The type is not part of this project.
    #[error("the type is unknown to this program")]
    Unknown,
    /// No installed package contains the file.
    #[error(
        "the folders of AMENT_PREFIX_PATH do not contain {0}. Source the workspace of this package first"
    )]
    NotInstalled(String),
    /// The publisher's type has a different hash.
    #[error("the publisher uses another version of the type ({announced}, not {known})")]
    Version {
        /// Hash announced by the publisher.
        announced: String,
        /// Hash of the known definition.
        known: String,
    },
    /// The texts do not define the type.
    #[error(transparent)]
    Text(#[from] planesman_rosidl::Error),
    /// The publisher's node omits the text of a type.
    #[error("the publisher's node returned no definition of {0}")]
    NoText(String),
    /// The publisher's node refuses; contains its message.
    #[error("{0}")]
    Refused(String),
    /// The publisher's node does not answer.
    #[error(transparent)]
    NoAnswer(#[from] crate::Error),
    /// The type is unknown here, and no publisher's node serves `~/get_type_description`.
    #[error("{0}, and no node that publishes the topic can describe the type")]
    Undescribed(Box<Self>),
}

/// Sources of definitions.
#[derive(Clone, Default)]
pub struct Definitions {
    packages: Rc<[PathBuf]>,
    /// Clients by service name.
    describers: Rc<RefCell<BTreeMap<String, Client<GetTypeDescription>>>>,
}

impl Definitions {
    /// Uses the installed packages of `AMENT_PREFIX_PATH`.
    #[must_use]
    pub fn from_environment() -> Self {
        let paths = env::var_os("AMENT_PREFIX_PATH").unwrap_or_default();
        Self {
            packages: env::split_paths(&paths).collect(),
            describers: Rc::default(),
        }
    }

    /// Definition of the topic's type from this project or an installed package.
    ///
    /// # Errors
    /// The reason why there is no definition.
    pub fn local(&self, topic: &PublishedTopic) -> Result<Definition, DefinitionError> {
        local(&topic.type_name, topic.type_hash.as_deref(), &self.packages)
    }

    /// Finds the definition of the topic's type, also by asking the publishers' nodes.
    pub fn find<E: 'static>(
        &self,
        rt: &Runtime<E>,
        topic: &PublishedTopic,
    ) -> impl Future<Output = Result<Definition, DefinitionError>> + use<E> {
        let (definitions, topic, opener) = (self.clone(), topic.clone(), rt.client_opener());
        async move {
            let reason = match definitions.local(&topic) {
                Ok(found) => return Ok(found),
                Err(reason) => reason,
            };
            let since = Instant::now();
            let services = loop {
                let participant = opener.shared.participant();
                let known = participant.map_or_else(Vec::new, |it| describers(&it, &topic));
                if !known.is_empty() || since.elapsed() >= DESCRIPTION_TIMEOUT {
                    break known;
                }
                opener.shared.sleep(POLL_INTERVAL).await;
            };
            let mut outcome = Err(DefinitionError::Undescribed(Box::new(reason)));
            for service in services.into_iter().take(MAX_DESCRIBERS) {
                let Some(client) = definitions.describer(&service, &opener) else {
                    continue;
                };
                outcome = ask(&client, &topic).await;
                if outcome.is_ok() {
                    break;
                }
            }
            outcome
        }
    }

    /// The client of a node's service, opened once.
    fn describer(
        &self,
        service: &str,
        opener: &ClientOpener,
    ) -> Option<Client<GetTypeDescription>> {
        let mut describers = self.describers.borrow_mut();
        if !describers.contains_key(service) {
            describers.insert(service.to_owned(), opener.open(service).ok()?);
        }
        describers.get(service).cloned()
    }
}

/// Definition as described by one node.
async fn ask(
    client: &Client<GetTypeDescription>,
    topic: &PublishedTopic,
) -> Result<Definition, DefinitionError> {
    let request = GetTypeDescriptionRequest {
        type_name: topic.type_name.clone(),
        type_hash: topic.type_hash.clone().unwrap_or_default(),
        include_type_sources: true,
    };
    match client.call(request, DESCRIPTION_TIMEOUT).await {
        Ok(answer) if answer.successful => described(
            &topic.type_name,
            topic.type_hash.as_deref(),
            &answer.type_sources,
        ),
        Ok(answer) => Err(DefinitionError::Refused(answer.failure_reason)),
        Err(error) => Err(error.into()),
    }
}

/// Definition of `type_name` from this project or from the packages in `prefixes` (`AMENT_PREFIX_PATH`). The definition's hash must match the hash
/// that the publisher announces, if there is one.
///
/// # Errors
/// The reason why there is no definition.
fn local(
    type_name: &str,
    announced: Option<&str>,
    prefixes: &[PathBuf],
) -> Result<Definition, DefinitionError> {
    own(type_name)
        .and_then(|known| fitting(known, announced))
        .or_else(|_| fitting(installed(type_name, prefixes)?, announced))
}

/// This project's own definition; for a part of a service or action, it is made from the text of the complete service or action.
fn own(type_name: &str) -> Result<Definition, DefinitionError> {
    if let Some(info) = type_info(type_name) {
        return Ok(Definition {
            text: info.definition.to_owned(),
            type_hash: info.type_hash.to_owned(),
        });
    }
    let name = parse_name(type_name)?;
    let file = TypeName::new(&name.package, name.kind, whole(&name));
    let known = describe(&file.to_string()).ok_or(DefinitionError::Unknown)?;
    described(type_name, None, &known.sources)
}

/// Definition from the texts in an answer of `~/get_type_description`.
///
/// # Errors
/// The texts do not define the type.
fn described(
    type_name: &str,
    announced: Option<&str>,
    sources: &[TypeSource],
) -> Result<Definition, DefinitionError> {
    let name = parse_name(type_name)?;
    let mut library = Library::new();
    for source in sources.iter().filter(|it| it.encoding != "implicit") {
        let name = parse_name(&source.type_name)?;
        let is_text = source.encoding == name.kind.as_str();
        if !is_text || source.raw_file_contents.is_empty() {
            return Err(DefinitionError::NoText(source.type_name.clone()));
        }
        add(&mut library, &name, &source.raw_file_contents)?;
    }
    fitting(definition(&library, &name)?, announced)
}

fn fitting(definition: Definition, announced: Option<&str>) -> Result<Definition, DefinitionError> {
    match announced {
        Some(hash) if hash != definition.type_hash => Err(DefinitionError::Version {
            announced: hash.to_owned(),
            known: definition.type_hash,
        }),
        _ => Ok(definition),
    }
}

fn parse_name(type_name: &str) -> Result<TypeName, DefinitionError> {
    TypeName::parse(type_name).ok_or_else(|| DefinitionError::Name(type_name.to_owned()))
}

fn definition(library: &Library, name: &TypeName) -> Result<Definition, DefinitionError> {
    library.check()?;
    Ok(Definition {
        text: library.schema(name)?,
        type_hash: library.type_hash(name)?,
    })
}

/// Adds the type in a file's text; for a part of a service or action (`Fit_Event`), the text is that of the complete service or action.
fn add(library: &mut Library, name: &TypeName, text: &str) -> Result<(), Error> {
    let (package, whole) = (&name.package, whole(name));
    match name.kind {
        Kind::Msg => library.add_message(parse_message(package, whole, text)?),
        Kind::Srv => library.add_service(parse_service(package, whole, text)?),
        Kind::Action => library.add_action(parse_action(package, whole, text)?),
    }
}

/// Name of the file that defines the type.
fn whole(name: &TypeName) -> &str {
    match name.kind {
        Kind::Msg => &name.name,
        Kind::Srv | Kind::Action => name.name.split('_').next().unwrap_or_default(),
    }
}

/// Definition from the files of installed packages.
fn installed(type_name: &str, prefixes: &[PathBuf]) -> Result<Definition, DefinitionError> {
    let name = parse_name(type_name)?;
    let mut library = Library::new();
    let mut wanted = vec![name.clone()];
    while !wanted.is_empty() {
        for next in wanted {
            if library.message(&next).is_some() {
                continue;
            }
            let (kind, package) = (next.kind.as_str(), &next.package);
            let file = format!("share/{package}/{kind}/{}.{kind}", whole(&next));
            let text = prefixes
                .iter()
                .find_map(|prefix| planesman_text::read(&prefix.join(&file)).ok())
                .ok_or(DefinitionError::NotInstalled(file))?;
            add(&mut library, &next, &text)?;
            library.expect_message(&next)?;
        }
        let references = library.messages().flat_map(|message| message.references());
        let unknown = references.filter(|(name, _)| library.message(name).is_none());
        wanted = unknown.map(|(name, _)| name.clone()).collect();
    }
    definition(&library, &name)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use planesman_msgs::{Message, planesman_msgs::msg::VehicleState};

    use super::*;

    #[test]
    fn a_type_is_found_here_in_installed_packages_and_in_a_nodes_answer() {
        let own = local(VehicleState::TYPE_NAME, None, &[]).expect("our own");
        assert_eq!(own.text, VehicleState::DEFINITION);
        assert_eq!(own.type_hash, VehicleState::TYPE_HASH);
        let sources = describe(VehicleState::TYPE_NAME).expect("ours").sources;
        let said = described(VehicleState::TYPE_NAME, Some(&own.type_hash), &sources);
        assert_eq!(said.expect("described"), own);
        let event = local("std_srvs/srv/SetBool_Event", None, &[]).expect("our own");
        assert!(
            event.text.contains("service_msgs/ServiceEventInfo"),
            "{}",
            event.text
        );

        let folder = tempfile::tempdir().expect("a temporary folder");
        let write = |file: &str, text: &str| {
            let path = folder.path().join("share").join(file);
            fs::create_dir_all(path.parent().expect("a folder")).expect("room");
            fs::write(path, text).expect("room");
        };
        write("a_msgs/msg/Outer.msg", "Inner[] inner\nb_msgs/Far far\n");
        write("a_msgs/msg/Inner.msg", "float64 x\n");
        write("b_msgs/msg/Far.msg", "a_msgs/Inner inner\n");
        let prefixes = [PathBuf::from("/nowhere"), folder.path().to_owned()];
        let found = local("a_msgs/msg/Outer", None, &prefixes).expect("it is installed");
        assert!(found.text.contains("MSG: b_msgs/Far"), "{}", found.text);
        assert!(local("a_msgs/msg/Outer", Some(&found.type_hash), &prefixes).is_ok());
        let other = local("a_msgs/msg/Outer", Some("RIHS01_0"), &prefixes);
        assert!(matches!(other, Err(DefinitionError::Version { .. })));
        // A service's event, whose type no file has by that name.
        write("a_msgs/srv/Ask.srv", "Inner inner\n---\nbool done\n");
        write(
            "service_msgs/msg/ServiceEventInfo.msg",
            "uint8 event_type\n",
        );
        let event = local("a_msgs/srv/Ask_Event", None, &prefixes).expect("it is installed");
        assert!(
            event.text.contains("MSG: a_msgs/srv/Ask_Request"),
            "{}",
            event.text
        );

        write("a_msgs/msg/Loop.msg", "Loop loop\n");
        for (name, reason) in [
            ("a_msgs/msg/Loop", "Loop"),
            (
                "a_msgs/msg/Nothing",
                "do not contain share/a_msgs/msg/Nothing.msg",
            ),
            ("a_msgs/msg/../x", "not a type name"),
            ("nothing", "not a type name"),
        ] {
            let refusal = local(name, None, &prefixes).expect_err(name).to_string();
            assert!(refusal.contains(reason), "{refusal}");
        }
        assert!(described("a/msg/B", None, &[]).is_err());
    }
}
