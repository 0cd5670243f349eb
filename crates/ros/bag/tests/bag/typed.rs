//! Every message type of the project goes into a bag and comes out of it.

use planesman_bag::{BagReader, BagWriter, OfferedQos, Order, Topic, WriteError, WriterOptions};
use planesman_msgs::{
    Message, cdr,
    planesman_msgs::msg::VehicleState,
    std_msgs::msg::{Float64, Header},
};

#[test]
fn every_type_is_described_by_its_bag() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("all");
    let mut writer = BagWriter::create(&path, WriterOptions::default()).expect("a new bag");
    for info in planesman_msgs::registry() {
        let name = format!("/{}", info.type_name.to_lowercase());
        writer
            .add_topic(&Topic::of_type(info, name, OfferedQos::reliable(10)))
            .expect("a new topic");
    }
    writer.close().expect("room on the disk");
    let bag = BagReader::open(&path).expect("a bag");
    assert_eq!(bag.topics().len(), planesman_msgs::registry().len());
    for count in bag.topics() {
        let info = planesman_msgs::type_info(&count.topic.kind.type_name).expect("a known type");
        assert_eq!(count.topic.kind.definition, info.definition);
        assert_eq!(count.topic.kind.type_hash, info.type_hash);
        assert_eq!(count.topic.kind.offered_qos, [OfferedQos::reliable(10)]);
    }
}

#[test]
fn a_message_comes_back_as_it_was() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("state.mcap");
    let mut writer = BagWriter::create_file(&path, WriterOptions::default()).expect("a new file");
    let topic = Topic::of::<VehicleState>("/auv/state", OfferedQos::reliable(10));
    let id = writer.add_topic(&topic).expect("a new topic");
    let state = VehicleState {
        depth: 0.914,
        header: Header {
            frame_id: "odom".to_owned(),
            ..Header::default()
        },
        ..VehicleState::default()
    };
    writer.write(id, &state, 7).expect("room on the disk");
    let refused = writer.write(id, &Float64 { data: 1.0 }, 8);
    assert!(matches!(refused, Err(WriteError::WrongType { .. })));
    writer.close().expect("room on the disk");

    let bag = BagReader::open(&path).expect("a bag");
    let messages: Vec<_> = bag
        .messages(Order::File)
        .collect::<Result<_, _>>()
        .expect("an undamaged bag");
    assert_eq!(messages.len(), 1);
    assert_eq!(messages[0].topic.kind.type_name, VehicleState::TYPE_NAME);
    assert_eq!(
        messages[0].decode::<VehicleState>().expect("a state"),
        state
    );
    assert_eq!(messages[0].payload, cdr::to_bytes(&state));
    assert!(messages[0].decode::<Float64>().is_err());
}
