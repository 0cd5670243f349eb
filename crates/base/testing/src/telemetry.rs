//! Telemetry logs of MAVLink put together byte by byte. Layouts: mavlink.io, "Packet Serialization" and the dialect `common`.

/// The seeds of the checksums, and the numbers, of the messages that are written here.
const ATTITUDE: (u32, u8) = (30, 39);
const SERVO_OUTPUT_RAW: (u32, u8) = (36, 222);
const NAMED_VALUE_FLOAT: (u32, u8) = (251, 170);

/// The version of the frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Version {
    /// Whole payloads.
    One,
    /// Zeros at the end of a payload are left out.
    Two,
}

fn checksum(bytes: &[u8]) -> [u8; 2] {
    // Bit by bit: the polynomial x^16 + x^12 + x^5 + 1, reflected.
    let crc = bytes.iter().fold(0xffff_u16, |crc, byte| {
        (0..8).fold(crc ^ u16::from(*byte), |crc, _| {
            let shifted = crc >> 1;
            if crc & 1 == 1 {
                shifted ^ 0x8408
            } else {
                shifted
            }
        })
    });
    crc.to_le_bytes()
}

/// A frame that was received at that time, us since 1970, of that system.
fn frame(version: Version, at: u64, system: u8, (id, seed): (u32, u8), payload: &[u8]) -> Vec<u8> {
    let id = id.to_le_bytes();
    let zeros = payload.iter().rev().take_while(|it| **it == 0).count();
    let kept = match version {
        Version::One => payload,
        Version::Two => &payload[..(payload.len() - zeros).max(1)],
    };
    let length = kept.len() as u8;
    let head = match version {
        Version::One => vec![length, 7, system, 1, id[0]],
        Version::Two => vec![length, 0, 0, 7, system, 1, id[0], id[1], id[2]],
    };
    let magic = match version {
        Version::One => 0xfe,
        Version::Two => 0xfd,
    };
    let checked = [&head, kept].concat();
    let sum = checksum(&[&checked[..], &[seed]].concat());
    [&at.to_be_bytes()[..], &[magic], &checked, &sum].concat()
}

/// Commands `u` as pulses of 1500 + 100 u us on output 3, rates `y` about the long axis, every 50 ms, and the values named `pitch`
/// and `roll` of those; each of system 1, and of a second system with the rate's sign turned if there are two.
pub fn log(response: &[(f64, f64)], version: Version, systems: u8) -> Vec<u8> {
    let mut bytes = Vec::new();
    for (k, (u, y)) in response.iter().enumerate() {
        let boot = 50 * k as u32;
        let at = 1_700_000_000_000_000 + 50_000 * k as u64;
        for system in 1..=systems {
            let sign = if system == 1 { 1.0 } else { -1.0 };
            let mut servo = vec![0; 21];
            servo[..4].copy_from_slice(&(boot * 1000).to_le_bytes());
            servo[8..10].copy_from_slice(&((1500.0 + 100.0 * u) as u16).to_le_bytes());
            let mut attitude = vec![0; 28];
            attitude[..4].copy_from_slice(&boot.to_le_bytes());
            attitude[16..20].copy_from_slice(&((sign * y) as f32).to_le_bytes());
            bytes.extend(frame(version, at, system, SERVO_OUTPUT_RAW, &servo));
            bytes.extend(frame(version, at, system, ATTITUDE, &attitude));
        }
        for (name, value) in [("roll", *y), ("pitch", *u)] {
            let mut named = boot.to_le_bytes().to_vec();
            named.extend((value as f32).to_le_bytes());
            named.extend(name.as_bytes());
            named.resize(18, 0);
            bytes.extend(frame(version, at, 1, NAMED_VALUE_FLOAT, &named));
        }
        // Of a dialect that nobody knows.
        if k % 100 == 0 {
            bytes.extend(frame(Version::Two, at, 1, (60_000, 0), &[1, 2, 3]));
        }
    }
    bytes
}
