//! The bag's contents so far, as rosbag2 metadata.

use std::collections::BTreeMap;

use super::{BagWriter, Channel};
use crate::metadata::{
    self, BagMetadata, DROPPED, FileInformation, NEVER, StartingTime, TopicMetadata, TopicWithCount,
};

impl BagWriter {
    /// Metadata of the bag so far.
    pub(super) fn account(&self) -> BagMetadata {
        let mut files = self.closed.clone();
        files.push(self.current_file());
        let dropped: BTreeMap<_, _> = self
            .channels
            .iter()
            .filter(|channel| channel.dropped > 0)
            .map(|channel| {
                (
                    format!("{DROPPED}{}", channel.topic.name),
                    channel.dropped.to_string(),
                )
            })
            .collect();
        BagMetadata {
            custom_data: (!dropped.is_empty()).then_some(dropped),
            ..self.account_of(files, |channel| channel.messages)
        }
    }

    /// Metadata of the current file.
    pub(super) fn account_of_file(&self) -> BagMetadata {
        if self.closed.is_empty() {
            return self.account();
        }
        self.account_of(vec![self.current_file()], |channel| {
            channel.messages - channel.before
        })
    }

    pub(super) fn current_file(&self) -> FileInformation {
        let name = self.file.file_name().unwrap_or_default();
        FileInformation {
            path: name.to_string_lossy().into_owned(),
            starting_time: StartingTime {
                nanoseconds_since_epoch: self.span.map_or(NEVER, |(first, _)| first),
            },
            duration: metadata::Duration {
                nanoseconds: self.span.map_or(0, |(first, last)| last - first),
            },
            message_count: self
                .channels
                .iter()
                .map(|channel| channel.messages - channel.before)
                .sum(),
        }
    }

    /// Metadata of these files, with the given numbers of messages per topic.
    fn account_of(
        &self,
        files: Vec<FileInformation>,
        messages: impl Fn(&Channel) -> u64,
    ) -> BagMetadata {
        let start = files.iter().map(|file| file.starting_time).min();
        let start = start.unwrap_or(StartingTime {
            nanoseconds_since_epoch: NEVER,
        });
        let ends = files.iter().filter(|file| file.message_count > 0);
        let ends =
            ends.map(|file| file.starting_time.nanoseconds_since_epoch + file.duration.nanoseconds);
        BagMetadata {
            duration: metadata::Duration {
                nanoseconds: ends
                    .max()
                    .map_or(0, |end| end - start.nanoseconds_since_epoch),
            },
            starting_time: start,
            message_count: self.channels.iter().map(&messages).sum(),
            topics_with_message_count: self
                .channels
                .iter()
                .map(|channel| TopicWithCount {
                    topic_metadata: TopicMetadata {
                        name: channel.topic.name.clone(),
                        type_name: channel.topic.kind.type_name.clone(),
                        serialization_format: channel.topic.kind.message_encoding.clone(),
                        offered_qos_profiles: channel.topic.kind.offered_qos.clone(),
                        type_description_hash: channel.topic.kind.type_hash.clone(),
                    },
                    message_count: messages(channel),
                })
                .collect(),
            relative_file_paths: files.iter().map(|file| file.path.clone()).collect(),
            files,
            ..BagMetadata::empty()
        }
    }
}
