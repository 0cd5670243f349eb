//! Tests of the patches to RustDDS, from outside.
#![allow(clippy::unwrap_used)]

use std::{
    net::{Ipv4Addr, SocketAddr, UdpSocket},
    sync::atomic::{AtomicI32, Ordering},
    time::{Duration, Instant},
};

use planesman_node::testing::OwnDomain;
use rustdds::{
    DomainParticipant, DomainParticipantBuilder, DomainParticipantStatusEvent, GUID, QosPolicies,
    QosPolicyBuilder, RTPSEntity as _, StatusEvented as _, TopicKind,
    discovery::announce_type_hash,
    no_key::{DataReader, DataWriter},
    policy::{Durability, History, Reliability},
};

/// Longest that anything here may take; reached only when something is broken.
const PATIENCE: Duration = Duration::from_secs(20);

fn participant(domain: &OwnDomain) -> DomainParticipant {
    DomainParticipantBuilder::new(domain.id())
        .with_only_networks([Ipv4Addr::LOCALHOST])
        .build()
        .unwrap()
}

fn reliable() -> QosPolicyBuilder {
    QosPolicyBuilder::new()
        .reliability(Reliability::Reliable {
            max_blocking_time: rustdds::Duration::ZERO,
        })
        .history(History::KeepLast { depth: 10 })
}

fn writer(participant: &DomainParticipant, qos: &QosPolicies) -> DataWriter<u32> {
    let topic = participant
        .create_topic(
            "numbers".to_owned(),
            "Number".to_owned(),
            qos,
            TopicKind::NoKey,
        )
        .unwrap();
    let publisher = participant.create_publisher(qos).unwrap();
    publisher
        .create_datawriter_no_key_cdr(&topic, None)
        .unwrap()
}

fn reader(participant: &DomainParticipant, qos: &QosPolicies) -> DataReader<u32> {
    let topic = participant
        .create_topic(
            "numbers".to_owned(),
            "Number".to_owned(),
            qos,
            TopicKind::NoKey,
        )
        .unwrap();
    let subscriber = participant.create_subscriber(qos).unwrap();
    subscriber
        .create_datareader_no_key_cdr(&topic, None)
        .unwrap()
}

/// Waits for `found` to find something.
fn wait_for<T>(mut found: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = found() {
            return found;
        }
        assert!(start.elapsed() < PATIENCE, "nothing happens");
        std::thread::sleep(Duration::from_millis(10));
    }
}

fn take(reader: &mut DataReader<u32>) -> Option<u32> {
    let sample = reader.take_next_sample().unwrap()?;
    Some(*sample.value())
}

/// An RTPS 2.3 datagram from `writer` with one little-endian submessage for any reader.
fn datagram(writer: GUID, kind: u8, body: &[u8]) -> Vec<u8> {
    let guid = writer.to_bytes();
    let mut bytes = b"RTPS\x02\x03\x01\x12".to_vec();
    bytes.extend_from_slice(&guid[..12]);
    let length = u16::try_from(8 + body.len()).unwrap();
    bytes.extend([kind, 0x01]);
    bytes.extend(length.to_le_bytes());
    bytes.extend([0; 4]);
    bytes.extend_from_slice(&guid[12..]);
    bytes.extend_from_slice(body);
    bytes
}

/// A sequence number on the wire: high word, low word.
fn sequence_number(number: i64) -> Vec<u8> {
    let high = i32::try_from(number >> 32).unwrap().to_le_bytes();
    let low = (number as u32).to_le_bytes();
    [high, low].concat()
}

/// HEARTBEAT (RTPS 2.3, 9.4.5.7): first and last number, and a count above those before.
fn heartbeat(writer: GUID, first: i64, last: i64) -> Vec<u8> {
    static COUNT: AtomicI32 = AtomicI32::new(1_000_000);
    let count = COUNT.fetch_add(1, Ordering::Relaxed).to_le_bytes().to_vec();
    let body = [sequence_number(first), sequence_number(last), count].concat();
    datagram(writer, 0x07, &body)
}

/// GAP (RTPS 2.3, 9.4.5.6): everything from `start` to below `base`, and an empty set.
fn gap(writer: GUID, start: i64, base: i64) -> Vec<u8> {
    let none = 0_u32.to_le_bytes().to_vec();
    let body = [sequence_number(start), sequence_number(base), none].concat();
    datagram(writer, 0x08, &body)
}

/// The process's resident memory, bytes.
fn resident() -> u64 {
    let statm = std::fs::read_to_string("/proc/self/statm").unwrap();
    let pages: u64 = statm.split(' ').nth(1).unwrap().parse().unwrap();
    pages * 4096
}

#[test]
fn datagrams_that_claim_absurd_sample_numbers_cost_no_memory_and_stop_nobody() {
    /// Room for the noise of two participants.
    const SLACK: u64 = 100 << 20;

    // A broken middleware takes this test's process down, not the machine.
    planesman_node::memory::limit(&planesman_node::ReceiveLimits::small()).unwrap();
    let domain = OwnDomain::claim().unwrap();
    let (here, there) = (participant(&domain), participant(&domain));
    let qos = reliable().build();
    let (known, mut reader) = (writer(&here, &qos), reader(&there, &qos));
    let mut number = 0;
    let mut exchange = |writer: &DataWriter<u32>| {
        number += 1;
        wait_for(|| {
            let _ = writer.write(number, None);
            take(&mut reader).filter(|taken| *taken >= number)
        })
    };
    exchange(&known);
    let targets: Vec<SocketAddr> = here
        .discovered_readers()
        .iter()
        .filter(|found| found.subscription_topic_data.topic_name() == "numbers")
        .flat_map(|found| found.reader_proxy.unicast_locator_list.clone())
        .map(SocketAddr::from)
        .filter(|address| address.is_ipv4())
        .collect();
    assert!(!targets.is_empty());
    let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    let send = |bytes: &[u8]| {
        for target in &targets {
            socket.send_to(bytes, target).unwrap();
        }
    };

    let before = resident();
    send(&heartbeat(known.guid(), 1, 1 << 40));
    exchange(&known);
    assert!(resident() < before + SLACK);
    // From here on the reader takes `known` to be far ahead of what it sends. It must
    // still receive from others.
    send(&gap(known.guid(), 1 << 20, 1 << 40));
    send(&heartbeat(known.guid(), i64::MAX - 1, i64::MAX));
    exchange(&writer(&here, &qos));
    assert!(resident() < before + SLACK);
}

#[test]
fn endpoints_tell_their_type_hash_and_participants_a_lease_of_five_seconds() {
    let domain = OwnDomain::claim().unwrap();
    announce_type_hash("Number", "RIHS01_12ab");
    let (here, there) = (participant(&domain), participant(&domain));
    let status = here.status_listener();
    let qos = reliable().build();
    let _endpoints = (writer(&there, &qos), reader(&there, &qos));
    let announced =
        |user_data: &[u8]| String::from_utf8_lossy(user_data).contains("typehash=RIHS01_12ab;");
    wait_for(|| {
        let writers = here.discovered_writers();
        let readers = here.discovered_readers();
        let writer = writers
            .iter()
            .find(|w| w.publication_topic_data.topic_name == "numbers")?;
        let reader = readers
            .iter()
            .find(|r| r.subscription_topic_data.topic_name() == "numbers")?;
        assert!(announced(&writer.user_data) && announced(&reader.user_data));
        Some(())
    });
    let lease = wait_for(|| match status.try_recv_status()? {
        DomainParticipantStatusEvent::ParticipantDiscovered { dpd } if dpd.guid == there.guid() => {
            dpd.lease_duration
        }
        _ => None,
    });
    assert_eq!(lease, rustdds::Duration::from_secs(5));
}

#[test]
fn a_late_joiner_gets_no_more_than_the_latched_depth() {
    let domain = OwnDomain::claim().unwrap();
    let (here, there) = (participant(&domain), participant(&domain));
    let qos = reliable()
        .durability(Durability::TransientLocal)
        .history(History::KeepLast { depth: 3 })
        .build();
    let writer = writer(&here, &qos);
    for number in 0..100 {
        writer.write(number, None).unwrap();
    }
    // The middleware trims histories every four seconds.
    std::thread::sleep(Duration::from_secs(9));
    let everything = reliable()
        .durability(Durability::TransientLocal)
        .history(History::KeepLast { depth: 1000 })
        .build();
    let mut reader = reader(&there, &everything);
    let mut taken = Vec::new();
    wait_for(|| {
        taken.extend(take(&mut reader));
        (taken.last() == Some(&99)).then_some(())
    });
    assert_eq!(taken, [97, 98, 99]);
}
