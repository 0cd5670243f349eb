//! Logs of ArduPilot put together byte by byte. Layouts: ArduPilot, `libraries/AP_Logger/LogStructure.h`.

/// The format of a kind of message: number, name, letters and names of its fields, and their bytes.
pub fn format(number: u8, name: &str, letters: &str, names: &str, size: u8) -> Vec<u8> {
    let padded = |text: &str, length: usize| {
        let mut bytes = text.as_bytes().to_vec();
        bytes.resize(length, 0);
        bytes
    };
    [
        vec![0xa3, 0x95, 128, number, size + 3],
        padded(name, 4),
        padded(letters, 16),
        padded(names, 64),
    ]
    .concat()
}

/// Rates of demand `u` and answer `y` every 50 ms, in rad/s, and in degrees of hundredths (letter `c`) from two gyros, of
/// which the second has the sign turned; and the demand again in a controller's terms.
pub fn log(response: &[(f64, f64)]) -> Vec<u8> {
    let mut bytes = [
        format(128, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns", 86),
        format(140, "FMTU", "QBNN", "TimeUS,FmtType,UnitIds,MultIds", 41),
        format(70, "RATE", "Qff", "TimeUS,RDes,R", 16),
        format(71, "IMU", "QBc", "TimeUS,I,GyrX", 11),
        format(72, "MSG", "QZ", "TimeUS,Message", 72),
        format(73, "PIDR", "Qff", "TimeUS,Tar,I", 16),
    ]
    .concat();
    let mut units = vec![0xa3, 0x95, 140];
    units.extend(0_u64.to_le_bytes());
    units.push(71);
    units.extend(b"s#E\0\0\0\0\0\0\0\0\0\0\0\0\0F-B\0\0\0\0\0\0\0\0\0\0\0\0\0");
    bytes.extend(units);
    for (k, (u, y)) in response.iter().enumerate() {
        let stamp = (5_000_000 + 50_000 * k as u64).to_le_bytes();
        bytes.extend([0xa3, 0x95, 70]);
        bytes.extend(stamp);
        bytes.extend((*u as f32).to_le_bytes());
        bytes.extend((*y as f32).to_le_bytes());
        for (instance, sign) in [(0, 1.0), (1, -1.0)] {
            let hundredths = (sign * y * 5730.0).round() as i16;
            bytes.extend([0xa3, 0x95, 71]);
            bytes.extend(stamp);
            bytes.push(instance);
            bytes.extend(hundredths.to_le_bytes());
        }
        bytes.extend([0xa3, 0x95, 73]);
        bytes.extend(stamp);
        bytes.extend((*u as f32).to_le_bytes());
        bytes.extend((0.01 * k as f32).to_le_bytes());
        if k == 20 {
            bytes.extend([0xa3, 0x95, 72]);
            bytes.extend(stamp);
            bytes.extend([b'x'; 64]);
        }
    }
    bytes
}
