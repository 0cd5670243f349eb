//! PX4 logs put together byte by byte. Layouts: PX4 user guide, "ULog File Format".

/// A log: header, flags, three formats, three subscriptions, the commands `u` on the first two and the rates `y` on the third
/// every 50 ms, and a dropout.
pub fn log(response: &[(f64, f64)]) -> Vec<u8> {
    let mut bytes = b"ULog\x01\x12\x35\x01".to_vec();
    bytes.extend(0_u64.to_le_bytes());
    let mut put = |kind: u8, body: &[u8]| {
        bytes.extend((body.len() as u16).to_le_bytes());
        bytes.push(kind);
        bytes.extend(body);
    };
    put(b'B', &[0; 40]);
    put(
        b'F',
        b"command:uint64_t timestamp;float[2] control;uint8_t[4] _padding0;",
    );
    put(b'F', b"rates:uint64_t timestamp;xyz body;bool ok;");
    put(b'F', b"xyz:double x;double y;");
    for (instance, id, name) in [(0, 5_u16, "command"), (1, 6, "command"), (0, 7, "rates")] {
        put(
            b'A',
            &[&[instance], &id.to_le_bytes()[..], name.as_bytes()].concat(),
        );
    }
    for (k, (u, y)) in response.iter().enumerate() {
        let stamp = (1_000_000 + 50_000 * k as u64).to_le_bytes();
        let half = (0.5_f32).to_le_bytes();
        for (id, value) in [(5_u16, *u), (6, -u)] {
            let control = (value as f32).to_le_bytes();
            put(
                b'D',
                &[&id.to_le_bytes()[..], &stamp, &half, &control].concat(),
            );
        }
        put(
            b'D',
            &[
                &7_u16.to_le_bytes()[..],
                &stamp,
                &1_f64.to_le_bytes(),
                &y.to_le_bytes(),
                &[1],
            ]
            .concat(),
        );
        if k == 20 {
            put(b'O', &1500_u16.to_le_bytes());
        }
    }
    bytes
}
