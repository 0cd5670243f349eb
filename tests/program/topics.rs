//! The loop's topics as docs/loop.md has them.

use planesman_msgs::loop_topics::{self, Delivery};

#[test]
fn each_topic_of_the_loop_is_documented_with_its_type_and_its_delivery() {
    let document = include_str!("../../docs/loop.md");
    let rows = document
        .lines()
        .skip_while(|line| !line.starts_with("| topic | type | QoS |"));
    let rows: Vec<&str> = rows.take_while(|line| line.starts_with('|')).collect();
    for topic in loop_topics::ALL {
        let name = format!("`{}`", topic.name);
        let row = rows.iter().find(|row| row.contains(&name));
        let row = row.unwrap_or_else(|| panic!("{name} is not documented"));
        let cells: Vec<&str> = row.split(" | ").collect();
        let [package, _, type_name] = topic.info.type_name.split('/').collect::<Vec<_>>()[..]
        else {
            panic!("{}", topic.info.type_name);
        };
        let shared = cells[1].contains(&format!("{package}/"));
        assert!(shared && cells[1].contains(type_name), "{row}");
        let told = match topic.delivery {
            Delivery::BestEffort => "best effort",
            Delivery::Reliable => "reliable",
            Delivery::Latched => "reliable, transient local",
        };
        assert!(
            cells[2].starts_with(told) || cells[2].starts_with("as the sensors"),
            "{row}"
        );
    }
}
