//! Selection of the topics to record, by the rules of `ros2 bag record`.

use planesman_parameters::Parameters;
use regex_lite::Regex;

/// End of the names of service introspection topics.
const SERVICE_EVENT: &str = "/_service_event";

/// The parameters `record.*`: which topics are recorded, by the rules of `ros2 bag record`. If all_topics, topics, topic_types,
/// regex, all_services and services are all unset, the loop's topics are recorded.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Record {
    /// Record every topic that is published in the domain.
    #[parameter(default = false, read_only)]
    pub all_topics: bool,
    /// Topics to record; a relative name is completed by the namespace.
    #[parameter(default = Vec::new(), read_only)]
    pub topics: Vec<String>,
    /// Record every topic of these types ('sensor_msgs/msg/Imu').
    #[parameter(default = Vec::new(), read_only)]
    pub topic_types: Vec<String>,
    /// Record every topic and every service whose name contains a match of this regular expression.
    #[parameter(default = "", read_only)]
    pub regex: String,
    /// Record the events of every service with introspection.
    #[parameter(default = false, read_only)]
    pub all_services: bool,
    /// Services whose events to record.
    #[parameter(default = Vec::new(), read_only)]
    pub services: Vec<String>,
    /// Topics not to record.
    #[parameter(default = Vec::new(), read_only)]
    pub exclude_topics: Vec<String>,
    /// Types of topics not to record.
    #[parameter(default = Vec::new(), read_only)]
    pub exclude_topic_types: Vec<String>,
    /// Record no topic and no service whose name contains a match of this regular expression.
    #[parameter(default = "", read_only)]
    pub exclude_regex: String,
    /// Services whose events not to record.
    #[parameter(default = Vec::new(), read_only)]
    pub exclude_services: Vec<String>,
    /// Record hidden topics, too: a part of their names begins with an underscore.
    #[parameter(default = false, read_only)]
    pub include_hidden_topics: bool,
    /// Record nothing until the service resume is called.
    #[parameter(default = false, read_only)]
    pub start_paused: bool,
}

/// A selection of topics by name and type.
#[derive(Clone, Debug)]
pub struct Selection {
    wanted: Record,
    regex: Option<Regex>,
    exclude_regex: Option<Regex>,
}

/// An invalid regular expression.
#[derive(Debug, thiserror::Error)]
#[error("record.{name}: '{text}' is not a regular expression: {reason}")]
pub struct NoRegex {
    name: &'static str,
    text: String,
    reason: regex_lite::Error,
}

impl Selection {
    /// Reads the parameters `record.*`; `expand` completes relative names.
    ///
    /// # Errors
    /// An invalid regular expression.
    pub fn new(record: &Record, expand: impl Fn(&str) -> String) -> Result<Self, NoRegex> {
        let regex = |name, text: &str| {
            let made = (!text.is_empty()).then(|| Regex::new(text)).transpose();
            made.map_err(|reason| NoRegex {
                name,
                text: text.to_owned(),
                reason,
            })
        };
        let absolute = |names: &[String]| names.iter().map(|name| expand(name)).collect();
        Ok(Self {
            regex: regex("regex", &record.regex)?,
            exclude_regex: regex("exclude_regex", &record.exclude_regex)?,
            wanted: Record {
                topics: absolute(&record.topics),
                services: absolute(&record.services),
                exclude_topics: absolute(&record.exclude_topics),
                exclude_services: absolute(&record.exclude_services),
                ..record.clone()
            },
        })
    }

    /// Whether topics are selected; otherwise the loop's topics are recorded, except the excluded ones.
    #[must_use]
    pub fn asks(&self) -> bool {
        let it = &self.wanted;
        it.all_topics
            || it.all_services
            || self.regex.is_some()
            || !(it.topics.is_empty() && it.topic_types.is_empty() && it.services.is_empty())
    }

    /// Whether a topic is recorded.
    #[must_use]
    pub fn takes(&self, topic: &str, type_name: &str) -> bool {
        let it = &self.wanted;
        let has = |names: &[String], name: &str| names.iter().any(|known| known == name);
        let matches =
            |regex: &Option<Regex>, name| regex.as_ref().is_some_and(|it| it.is_match(name));
        if let Some(service) = topic.strip_suffix(SERVICE_EVENT) {
            return (it.all_services
                || has(&it.services, service)
                || matches(&self.regex, service))
                && !has(&it.exclude_services, service)
                && !matches(&self.exclude_regex, service);
        }
        let is_wanted = !self.asks()
            || it.all_topics
            || has(&it.topics, topic)
            || has(&it.topic_types, type_name)
            || matches(&self.regex, topic);
        let is_hidden = topic.split('/').any(|token| token.starts_with('_'));
        is_wanted
            && !has(&it.exclude_topics, topic)
            && !has(&it.exclude_topic_types, type_name)
            && !matches(&self.exclude_regex, topic)
            && (it.include_hidden_topics || !is_hidden)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn selection(change: impl Fn(&mut Record)) -> Selection {
        let mut record = Record::default();
        change(&mut record);
        let expand = |name: &str| match name.starts_with('/') {
            true => name.to_owned(),
            false => format!("/auv/{name}"),
        };
        Selection::new(&record, expand).expect("good expressions")
    }

    #[test]
    fn topics_are_taken_as_ros2_bag_record_takes_them() {
        let names = |list: &[&str]| list.iter().map(|&it| it.to_owned()).collect::<Vec<_>>();
        let all = selection(|it| {
            it.all_topics = true;
            it.exclude_topics = names(&["scan"]);
            it.exclude_regex = "^/dvl/".to_owned();
            it.exclude_topic_types = names(&["a/msg/Image"]);
        });
        assert!(all.asks());
        for (topic, type_name, is_taken) in [
            ("/auv/state", "a/msg/B", true),
            ("/auv/scan", "a/msg/B", false),
            ("/dvl/raw", "a/msg/B", false),
            ("/camera", "a/msg/Image", false),
            ("/auv/_action/feedback", "a/msg/B", false),
            ("/auv/fit/_service_event", "a/srv/B_Event", false),
        ] {
            assert_eq!(all.takes(topic, type_name), is_taken, "{topic}");
        }
        let some = selection(|it| {
            it.topics = names(&["imu"]);
            it.regex = "p(ressure|ower)$".to_owned();
            it.topic_types = names(&["a/msg/Fix"]);
            it.services = names(&["fit"]);
        });
        for (topic, type_name, is_taken) in [
            ("/auv/imu", "a/msg/B", true),
            ("/imu", "a/msg/B", false),
            ("/x/pressure", "a/msg/B", true),
            ("/gps", "a/msg/Fix", true),
            ("/auv/fit/_service_event", "a/srv/B_Event", true),
            ("/auv/reset/_service_event", "a/srv/B_Event", false),
        ] {
            assert_eq!(some.takes(topic, type_name), is_taken, "{topic}");
        }
        let none = selection(|it| it.exclude_topics = names(&["imu"]));
        assert!(!none.asks());
        assert!(none.takes("/auv/state", "a/msg/B") && !none.takes("/auv/imu", "a/msg/B"));
        let record = Record {
            regex: "(".to_owned(),
            ..Record::default()
        };
        let refusal = Selection::new(&record, str::to_owned).expect_err("no expression");
        assert!(refusal.to_string().starts_with("record.regex: '('"));
    }
}
