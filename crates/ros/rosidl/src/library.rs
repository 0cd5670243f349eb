//! A set of definitions that use each other, with the types ROS derives from services and actions.
//!
//! rosidl derives further message types from each service and action. These derived types are sent on the wire, and are part of the type hashes:
//!
//! | definition | derived types |
//! |---|---|
//! | `srv/X` | `X_Request`, `X_Response`, `X_Event`, and `X` itself with those three as fields |
//! | `action/X` | `X_Goal`, `X_Result`, `X_Feedback`, the services `X_SendGoal` and `X_GetResult`, the message `X_FeedbackMessage`, and `X` itself with those six as fields |

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use crate::definition::{
    Action, Arity, Element, Field, FieldType, Kind, Message, Primitive, Service, TypeName,
};
use crate::error::{Error, MAX_DEPTH, Rule};
use crate::parse::{parse_action, parse_message, parse_service};

/// Definitions by name.
#[derive(Debug, Clone, Default)]
pub struct Library {
    messages: BTreeMap<TypeName, Message>,
    services: BTreeMap<TypeName, Service>,
    actions: BTreeMap<TypeName, Action>,
}

impl Library {
    /// An empty library.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Reads all definitions in the folders `msg`, `srv` and `action` below `folder`, as part of `package`.
    ///
    /// # Errors
    /// A file that cannot be read or parsed, with its path.
    pub fn read_package(&mut self, folder: &Path, package: &str) -> Result<(), Error> {
        for kind in Kind::ALL {
            let folder = folder.join(kind.as_str());
            if !folder.is_dir() {
                continue;
            }
            let shown = folder.display().to_string();
            let unreadable =
                |error: std::io::Error| Rule::Unreadable(error.to_string()).at(&shown, 0);
            let mut paths = Vec::new();
            for entry in folder.read_dir().map_err(unreadable)? {
                paths.push(entry.map_err(unreadable)?.path());
            }
            paths.sort();
            for path in paths {
                if path
                    .extension()
                    .is_some_and(|extension| extension == kind.as_str())
                {
                    self.read_file(&path, package, kind)?;
                }
            }
        }
        Ok(())
    }

    fn read_file(&mut self, path: &Path, package: &str, kind: Kind) -> Result<(), Error> {
        let shown = path.display().to_string();
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let text = std::fs::read_to_string(path)
            .map_err(|error| Rule::Unreadable(error.to_string()).at(&shown, 0))?;
        match kind {
            Kind::Msg => parse_message(package, &name, &text).and_then(|it| self.add_message(it)),
            Kind::Srv => parse_service(package, &name, &text).and_then(|it| self.add_service(it)),
            Kind::Action => parse_action(package, &name, &text).and_then(|it| self.add_action(it)),
        }
        .map_err(|error| Error {
            file: shown,
            ..error
        })
    }

    /// Adds a message.
    ///
    /// # Errors
    /// [`Rule::Duplicate`] if the name exists.
    pub fn add_message(&mut self, message: Message) -> Result<(), Error> {
        if self.messages.contains_key(&message.name) {
            return Err(Rule::Duplicate(message.name.to_string()).at(&message.file, 0));
        }
        self.messages.insert(message.name.clone(), message);
        Ok(())
    }

    /// Adds a service and the messages derived from the service.
    ///
    /// # Errors
    /// [`Rule::Duplicate`] if a name exists.
    pub fn add_service(&mut self, service: Service) -> Result<(), Error> {
        let Service {
            name,
            request,
            response,
        } = &service;
        let [request_name, response_name] = [request.name.clone(), response.name.clone()];
        let event = derived(
            name.derived("Event"),
            request,
            vec![
                (
                    "info",
                    one(TypeName::new("service_msgs", Kind::Msg, "ServiceEventInfo")),
                ),
                ("request", at_most_one(request_name.clone())),
                ("response", at_most_one(response_name.clone())),
            ],
        );
        let whole = derived(
            name.clone(),
            request,
            vec![
                ("request_message", one(request_name)),
                ("response_message", one(response_name)),
                ("event_message", one(event.name.clone())),
            ],
        );
        for message in [request.clone(), response.clone(), event, whole] {
            self.add_message(message)?;
        }
        self.services.insert(name.clone(), service);
        Ok(())
    }

    /// Adds an action and the messages and services derived from the action.
    ///
    /// # Errors
    /// [`Rule::Duplicate`] if a name exists.
    pub fn add_action(&mut self, action: Action) -> Result<(), Error> {
        let Action {
            name,
            goal,
            result,
            feedback,
        } = &action;
        let goal_id = (
            "goal_id",
            one(TypeName::new("unique_identifier_msgs", Kind::Msg, "UUID")),
        );
        let primitive = |primitive| FieldType {
            element: Element::Primitive(primitive),
            arity: Arity::One,
        };
        let stamp = one(TypeName::new("builtin_interfaces", Kind::Msg, "Time"));

        let send_goal = name.derived("SendGoal");
        let get_result = name.derived("GetResult");
        let part = |name: TypeName, fields| derived(name, goal, fields);
        let send_goal = Service {
            request: part(
                send_goal.derived("Request"),
                vec![goal_id.clone(), ("goal", one(goal.name.clone()))],
            ),
            response: part(
                send_goal.derived("Response"),
                vec![("accepted", primitive(Primitive::Bool)), ("stamp", stamp)],
            ),
            name: send_goal,
        };
        let get_result = Service {
            request: part(get_result.derived("Request"), vec![goal_id.clone()]),
            response: part(
                get_result.derived("Response"),
                vec![
                    ("status", primitive(Primitive::Int8)),
                    ("result", one(result.name.clone())),
                ],
            ),
            name: get_result,
        };
        let feedback_message = part(
            name.derived("FeedbackMessage"),
            vec![goal_id, ("feedback", one(feedback.name.clone()))],
        );
        let whole = part(
            name.clone(),
            vec![
                ("goal", one(goal.name.clone())),
                ("result", one(result.name.clone())),
                ("feedback", one(feedback.name.clone())),
                ("send_goal_service", one(send_goal.name.clone())),
                ("get_result_service", one(get_result.name.clone())),
                ("feedback_message", one(feedback_message.name.clone())),
            ],
        );
        for message in [
            goal.clone(),
            result.clone(),
            feedback.clone(),
            feedback_message,
            whole,
        ] {
            self.add_message(message)?;
        }
        self.add_service(send_goal)?;
        self.add_service(get_result)?;
        self.actions.insert(name.clone(), action);
        Ok(())
    }

    /// All messages, including derived messages, sorted by name.
    pub fn messages(&self) -> impl Iterator<Item = &Message> {
        self.messages.values()
    }

    /// All services, including the services of actions, sorted by name.
    pub fn services(&self) -> impl Iterator<Item = &Service> {
        self.services.values()
    }

    /// All actions, sorted by name.
    pub fn actions(&self) -> impl Iterator<Item = &Action> {
        self.actions.values()
    }

    /// The message with this name.
    #[must_use]
    pub fn message(&self, name: &TypeName) -> Option<&Message> {
        self.messages.get(name)
    }

    /// The message with this name, or an error.
    ///
    /// # Errors
    /// [`Rule::Unknown`].
    pub fn expect_message(&self, name: &TypeName) -> Result<&Message, Error> {
        self.message(name)
            .ok_or_else(|| Rule::Unknown(name.to_string()).at(&name.to_string(), 0))
    }

    /// Names of all messages that `name` uses directly or indirectly, without itself.
    ///
    /// # Errors
    /// [`Rule::Unknown`] for a type that is not in the library.
    pub fn dependencies(&self, name: &TypeName) -> Result<BTreeSet<&TypeName>, Error> {
        let mut found = BTreeSet::new();
        let mut to_visit = vec![self.expect_message(name)?];
        while let Some(message) = to_visit.pop() {
            for (reference, line) in message.references() {
                let definition = self
                    .message(reference)
                    .ok_or_else(|| Rule::Unknown(reference.to_string()).at(&message.file, line))?;
                if found.insert(reference) {
                    to_visit.push(definition);
                }
            }
        }
        Ok(found)
    }

    /// Checks that every used type is defined, and that no message contains itself or is nested deeper than [`MAX_DEPTH`].
    ///
    /// # Errors
    /// The first definition that violates one of these rules.
    pub fn check(&self) -> Result<(), Error> {
        for message in self.messages.values() {
            for (reference, line) in message.references() {
                if !self.messages.contains_key(reference) {
                    return Err(Rule::Unknown(reference.to_string()).at(&message.file, line));
                }
            }
        }
        let mut depths = BTreeMap::new();
        for name in self.messages.keys() {
            self.depth(name, 1, &mut depths)?;
        }
        Ok(())
    }

    /// Nesting depth of `name`, including itself; `None` in `depths` marks messages being walked.
    fn depth<'a>(
        &'a self,
        name: &'a TypeName,
        level: usize,
        depths: &mut BTreeMap<&'a TypeName, Option<usize>>,
    ) -> Result<usize, Error> {
        match depths.get(name) {
            Some(Some(depth)) => return Ok(*depth),
            Some(None) => {
                let file = &self.expect_message(name)?.file;
                return Err(Rule::Recursive(name.to_string()).at(file, 0));
            }
            None => {}
        }
        let message = self.expect_message(name)?;
        depths.insert(name, None);
        let mut deepest = 0;
        for (reference, line) in message.references() {
            if level >= MAX_DEPTH {
                return Err(Rule::TooDeep.at(&message.file, line));
            }
            deepest = deepest.max(self.depth(reference, level + 1, depths)?);
        }
        if deepest >= MAX_DEPTH {
            return Err(Rule::TooDeep.at(&message.file, 0));
        }
        depths.insert(name, Some(deepest + 1));
        Ok(deepest + 1)
    }
}

fn one(name: TypeName) -> FieldType {
    FieldType {
        element: Element::Message(name),
        arity: Arity::One,
    }
}

fn at_most_one(name: TypeName) -> FieldType {
    FieldType {
        element: Element::Message(name),
        arity: Arity::BoundedSequence(1),
    }
}

/// A derived message; `source`: a message from the file it is derived from.
fn derived(name: TypeName, source: &Message, fields: Vec<(&str, FieldType)>) -> Message {
    let text = fields
        .iter()
        .map(|(name, field_type)| format!("{field_type} {name}\n"))
        .collect();
    let fields = fields
        .into_iter()
        .map(|(name, field_type)| Field {
            name: name.to_owned(),
            field_type,
            default: None,
            comment: Vec::new(),
            line: 0,
        })
        .collect();
    Message {
        name,
        comment: Vec::new(),
        constants: Vec::new(),
        fields,
        text,
        file: source.file.clone(),
    }
}
