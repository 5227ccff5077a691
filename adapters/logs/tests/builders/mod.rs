//! Small logs of every format, made from the specifications of the formats.

#![allow(dead_code, reason = "each test program uses some of them")]
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a log that cannot be made is a failed test")]

/// Returns a ULog with `vehicle_attitude` (nested and array fields) and `battery_status`, a text and a drop-out.
/// Roll is `i` degrees at `i` tenths of a second.
pub(crate) fn ulog(samples: u64) -> Vec<u8> {
    let mut log = vec![0x55, 0x4c, 0x6f, 0x67, 0x01, 0x12, 0x35, 1];
    log.extend(1_000_000_u64.to_le_bytes());
    let mut message = |letter: u8, payload: &[u8]| {
        log.extend(u16::try_from(payload.len()).unwrap().to_le_bytes());
        log.push(letter);
        log.extend(payload);
    };
    message(b'B', &[0; 40]);
    message(b'F', b"vector:float x;float[2] yz;");
    message(b'F', b"vehicle_attitude:uint64_t timestamp;float[4] q;vector rate;uint8_t ok;uint8_t[3] _padding0;");
    message(b'F', b"battery_status:uint64_t timestamp;int16_t remaining;bool connected;char[4] name;");
    message(b'A', b"\x00\x07\x00vehicle_attitude");
    message(b'A', b"\x01\x08\x00battery_status");
    for index in 0..samples {
        let stamp = (1_000_000 + index * 100_000).to_le_bytes();
        let half = (index as f32).to_radians() / 2.0;
        let mut payload = vec![7, 0];
        payload.extend(stamp);
        for part in [half.cos(), half.sin(), 0.0, 0.0, 1.0, 2.0, 3.0] {
            payload.extend(part.to_le_bytes());
        }
        payload.push(1);
        message(b'D', &payload);
        let mut payload = vec![8, 0];
        payload.extend(stamp);
        payload.extend((-5_i16).to_le_bytes());
        payload.extend(b"\x01cell");
        message(b'D', &payload);
    }
    let mut said = vec![b'6'];
    said.extend(1_500_000_u64.to_le_bytes());
    said.extend(b"Takeoff detected");
    message(b'L', &said);
    message(b'O', &250_u16.to_le_bytes());
    log
}

/// Returns the definition of a kind of DataFlash messages.
fn definition(kind: u8, length: u8, name: &str, letters: &str, columns: &str) -> Vec<u8> {
    let mut row = vec![0xa3, 0x95, 128, kind, length];
    for (text, size) in [(name, 4), (letters, 16), (columns, 64)] {
        row.extend(padded(text, size));
    }
    row
}

fn padded(text: &str, size: usize) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    bytes.resize(size, 0);
    bytes
}

/// Returns a binary DataFlash log: `ATT` with hundredths of degrees and `POS` with coordinates, ten rows a second.
pub(crate) fn dataflash_binary(samples: u64) -> Vec<u8> {
    let mut log = definition(128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns");
    log.extend(definition(10, 3 + 8 + 2 + 4, "ATT", "Qcf", "TimeUS,Roll,Yaw"));
    log.extend(definition(11, 3 + 8 + 4 + 4, "POS", "QLe", "TimeUS,Lat,Alt"));
    for index in 0..samples {
        let stamp = (5_000_000 + index * 100_000).to_le_bytes();
        log.extend([0xa3, 0x95, 10]);
        log.extend(stamp);
        log.extend((index as i16 * 100).to_le_bytes());
        log.extend(90.5_f32.to_le_bytes());
        log.extend([0xa3, 0x95, 11]);
        log.extend(stamp);
        log.extend((-353_629_904_i32).to_le_bytes());
        log.extend(58_412_i32.to_le_bytes());
    }
    log
}

/// Returns a binary DataFlash log with units: barometers 0 and 1 in turn, and a battery monitor. Its voltage is a float in volts, or with
/// `integers` a whole number of hundredths. The definitions of units come before the rows.
pub(crate) fn dataflash_with_units(samples: u64, integers: bool) -> Vec<u8> {
    let mut log = definition(128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns");
    log.extend(definition(20, 3 + 8 + 1 + 64, "UNIT", "QbZ", "TimeUS,Id,Label"));
    log.extend(definition(21, 3 + 8 + 1 + 8, "MULT", "Qbd", "TimeUS,Id,Mult"));
    log.extend(definition(22, 3 + 8 + 1 + 32, "FMTU", "QBNN", "TimeUS,FmtType,UnitIds,MultIds"));
    log.extend(definition(30, 3 + 8 + 1 + 4 + 2, "BARO", "QBfh", "TimeUS,I,Alt,Fld"));
    let letters = if integers { "Qhh" } else { "Qff" };
    log.extend(definition(31, 3 + 8 + if integers { 4 } else { 8 }, "CURR", letters, "TimeUS,Volt,Curr"));
    let row = |kind: u8, stamp: u64, rest: &[u8]| [&[0xa3, 0x95, kind][..], &stamp.to_le_bytes(), rest].concat();
    for (id, label) in [(b's', "s"), (b'm', "m"), (b'G', "Gauss"), (b'#', "instance")] {
        log.extend(row(20, 1, &[vec![id], padded(label, 64)].concat()));
    }
    for (id, multiplier) in [(b'F', 1e-6_f64), (b'0', 1.0), (b'C', 1e-3)] {
        log.extend(row(21, 1, &[&[id][..], &multiplier.to_le_bytes()].concat()));
    }
    log.extend(row(22, 1, &[vec![30], padded("s#mG", 16), padded("F-0C", 16)].concat()));
    for index in 0..samples {
        let stamp = 5_000_000 + index * 100_000;
        let instance = (index % 2) as u8;
        let height = if instance == 0 { -(index as f32) } else { 0.0 };
        log.extend(row(30, stamp, &[&[instance][..], &height.to_le_bytes(), &250_i16.to_le_bytes()].concat()));
        let battery = if integers {
            [1_260_i16.to_le_bytes(), 450_i16.to_le_bytes()].concat()
        } else {
            [12.6_f32.to_le_bytes(), 4.5_f32.to_le_bytes()].concat()
        };
        log.extend(row(31, stamp, &battery));
    }
    log
}

/// Returns the same units as text.
pub(crate) fn dataflash_text_with_units() -> Vec<u8> {
    let lines = [
        "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns",
        "FMT, 30, 18, BARO, QBfh, TimeUS,I,Alt,Fld",
        "FMT, 20, 76, UNIT, QbZ, TimeUS,Id,Label",
        "FMT, 21, 20, MULT, Qbd, TimeUS,Id,Mult",
        "FMT, 22, 44, FMTU, QBNN, TimeUS,FmtType,UnitIds,MultIds",
        "UNIT, 1, 109, m",
        "UNIT, 1, 71, Gauss",
        "MULT, 1, 67, 0.001",
        "FMTU, 1, 30, s#mG, F-0C",
        "BARO, 5000000, 0, -1.5, 250",
        "BARO, 5100000, 1, 0.5, 250",
    ];
    lines.join("\n").into_bytes()
}

/// Returns a DataFlash text log of the old kind: only GPS rows have a time, and there are two ATT rows between each two of them.
pub(crate) fn dataflash_text(samples: u64) -> Vec<u8> {
    let mut log =
        "ArduCopter V3\r\nFMT, 130, 35, GPS, BI, Status,Time\r\nFMT, 1, 17, ATT, cc, RollIn,Roll\r\n".to_string();
    for index in 0..samples {
        log.push_str(&format!("GPS, 3, {}\r\nATT, 0.00, {index}.00\r\nATT, 0.00, {index}.50\r\n", index * 300));
    }
    log.push_str("GPS, 3, ");
    log.push_str(&(samples * 300).to_string());
    log.push_str("\r\n");
    log.into_bytes()
}

fn crc(bytes: &[u8], extra: u8) -> [u8; 2] {
    let mut crc = 0xffff_u16;
    for byte in bytes.iter().chain([&extra]) {
        let mut mixed = *byte ^ (crc & 0xff) as u8;
        mixed ^= mixed << 4;
        let mixed = u16::from(mixed);
        crc = (crc >> 8) ^ (mixed << 8) ^ (mixed << 3) ^ (mixed >> 4);
    }
    crc.to_le_bytes()
}

/// Returns a telemetry log: ATTITUDE in packets alternating between version 1 and version 2, and a ground station's HEARTBEAT between
/// them.
pub(crate) fn tlog(samples: u64) -> Vec<u8> {
    let mut log = Vec::new();
    for index in 0..samples {
        let stamp = (1_600_000_000_000_000_u64 + index * 100_000).to_be_bytes();
        let mut payload = (index as u32 * 100).to_le_bytes().to_vec();
        payload.extend((index as f32).to_radians().to_le_bytes());
        payload.extend(0.1_f32.to_le_bytes());
        // Zeros at the end are not sent in version 2.
        let first = index % 2 == 0;
        if first {
            payload.resize(28, 0);
        }
        let length = payload.len() as u8;
        let header = if first { vec![0xfe, length, 1, 1, 1, 30] } else { vec![0xfd, length, 0, 0, 1, 1, 1, 30, 0, 0] };
        let mut frame = header;
        frame.extend(&payload);
        let sum = crc(&frame[1..], 39);
        log.extend(stamp);
        log.extend(frame);
        log.extend(sum);
        let mut frame = vec![0xfe, 9, 1, 255, 190, 0];
        frame.extend([0; 9]);
        let sum = crc(&frame[1..], 50);
        log.extend(stamp);
        log.extend(frame);
        log.extend(sum);
    }
    log
}

fn record(code: u8, body: &[u8]) -> Vec<u8> {
    let mut record = vec![code];
    record.extend((body.len() as u64).to_le_bytes());
    record.extend(body);
    record
}

fn string(text: &str) -> Vec<u8> {
    let mut bytes = (text.len() as u32).to_le_bytes().to_vec();
    bytes.extend(text.as_bytes());
    bytes
}

/// Returns an MCAP file with JSON messages in chunks, alternately plain, LZ4 and Zstandard, and a channel that is not JSON.
pub(crate) fn mcap(samples: u64) -> Vec<u8> {
    let magic = [0x89, b'M', b'C', b'A', b'P', 0x30, b'\r', b'\n'];
    let mut log = magic.to_vec();
    log.extend(record(1, &[string(""), string("test")].concat()));
    for (number, topic, encoding) in [(1_u16, "/attitude", "json"), (2, "/raw", "cdr")] {
        let fixed = [number.to_le_bytes().to_vec(), 0_u16.to_le_bytes().to_vec()].concat();
        log.extend(record(4, &[fixed, string(topic), string(encoding), 0_u32.to_le_bytes().to_vec()].concat()));
    }
    for index in 0..samples {
        let mut inner = Vec::new();
        let json = format!("{{\"euler\": {{\"roll\": {index}}}, \"q\": [1, 0], \"mode\": \"AUTO\"}}");
        for (channel, data) in [(1_u16, json.as_bytes()), (2, &[1, 2, 3][..])] {
            let mut body = channel.to_le_bytes().to_vec();
            body.extend(0_u32.to_le_bytes());
            body.extend((index * 100_000_000).to_le_bytes());
            body.extend((index * 100_000_000).to_le_bytes());
            body.extend(data);
            inner.extend(record(5, &body));
        }
        let (compression, packed) = match index % 3 {
            0 => ("", inner.clone()),
            1 => {
                let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
                std::io::Write::write_all(&mut encoder, &inner).unwrap();
                ("lz4", encoder.finish().unwrap())
            }
            _ => {
                let level = ruzstd::encoding::CompressionLevel::Fastest;
                ("zstd", ruzstd::encoding::compress_to_vec(inner.as_slice(), level))
            }
        };
        let mut body = Vec::new();
        body.extend((index * 100_000_000).to_le_bytes());
        body.extend((index * 100_000_000).to_le_bytes());
        body.extend((inner.len() as u64).to_le_bytes());
        body.extend(0_u32.to_le_bytes());
        body.extend(string(compression));
        body.extend((packed.len() as u64).to_le_bytes());
        body.extend(packed);
        log.extend(record(6, &body));
    }
    log.extend(record(15, &0_u32.to_le_bytes()));
    log.extend(record(2, &[0; 20]));
    log.extend(magic);
    log
}

/// Returns an MCAP file with attitudes as written by ROS 2: in CDR, with the definition of the message as schema.
pub(crate) fn mcap_ros(samples: u64) -> Vec<u8> {
    let magic = [0x89, b'M', b'C', b'A', b'P', 0x30, b'\r', b'\n'];
    let mut log = magic.to_vec();
    log.extend(record(1, &[string("ros2"), string("test")].concat()));
    let definition = "std_msgs/Header header\nuint8 mode\ngeometry_msgs/Vector3 angle\nfloat32[] cells\n====\n\
                      MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n====\n\
                      MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n====\n\
                      MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n";
    let number = 7_u16.to_le_bytes().to_vec();
    log.extend(record(3, &[number, string("uav_msgs/msg/Attitude"), string("ros2msg"), string(definition)].concat()));
    let fixed = [1_u16.to_le_bytes(), 7_u16.to_le_bytes()].concat();
    log.extend(record(4, &[fixed, string("/attitude"), string("cdr"), 0_u32.to_le_bytes().to_vec()].concat()));
    for index in 0..samples {
        let mut body = 1_u16.to_le_bytes().to_vec();
        body.extend(0_u32.to_le_bytes());
        body.extend((index * 100_000_000).to_le_bytes());
        body.extend((index * 100_000_000).to_le_bytes());
        // Header of CDR; seconds, nanoseconds, "map" with its length; mode; up to 24 for the first double.
        body.extend([0, 1, 0, 0, 5, 0, 0, 0, 6, 0, 0, 0, 4, 0, 0, 0, b'm', b'a', b'p', 0, 3, 0, 0, 0, 0, 0, 0, 0]);
        for angle in [index as f64, 2.0, 3.0] {
            body.extend(angle.to_le_bytes());
        }
        body.extend(2_u32.to_le_bytes());
        body.extend([3.5_f32.to_le_bytes(), 4.5_f32.to_le_bytes()].concat());
        log.extend(record(5, &body));
    }
    log.extend(record(15, &0_u32.to_le_bytes()));
    log.extend(record(2, &[0; 20]));
    log.extend(magic);
    log
}

/// Returns a table with a time in milliseconds.
pub(crate) fn csv(samples: u64) -> Vec<u8> {
    let mut log = "# made by hand\ntime_ms,roll,mode\n".to_string();
    for index in 0..samples {
        log.push_str(&format!("{},{index},AUTO\n", index * 100));
    }
    log.into_bytes()
}

/// Returns a log of every format, each with the extension of its name.
pub(crate) fn all(samples: u64) -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("ulg", ulog(samples)),
        ("bin", dataflash_binary(samples)),
        ("log", dataflash_text(samples)),
        ("tlog", tlog(samples)),
        ("mcap", mcap(samples)),
        ("csv", csv(samples)),
    ]
}
