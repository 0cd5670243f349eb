//! ZIP archives without compression (PKWARE's APPNOTE 6.3, sections 4.3 and 4.4), the container of an FMU.

/// An archive of files by name, in their order. The date is the format's earliest, so that the same files give the same bytes.
pub(crate) fn zip(files: &[(String, Vec<u8>)]) -> Vec<u8> {
    let mut archive = Vec::new();
    let mut directory = Vec::new();
    for (name, bytes) in files {
        let offset = archive.len() as u32;
        // Version 2.0, flags: names are UTF-8; stored; 1 January 1980.
        let mut entry = Vec::new();
        for short in [20, 0x800, 0, 0, 0x21_u16] {
            entry.extend(short.to_le_bytes());
        }
        let size = bytes.len() as u32;
        for long in [crc32fast::hash(bytes), size, size] {
            entry.extend(long.to_le_bytes());
        }
        entry.extend((name.len() as u16).to_le_bytes());
        entry.extend(0_u16.to_le_bytes());
        archive.extend(0x0403_4b50_u32.to_le_bytes());
        archive.extend(&entry);
        archive.extend(name.as_bytes());
        archive.extend(bytes);
        // Written by version 2.0 of Unix; no comment, first disk, no attributes of text, a plain file that all may read.
        directory.extend(0x0201_4b50_u32.to_le_bytes());
        directory.extend((20_u16 | 3 << 8).to_le_bytes());
        directory.extend(&entry);
        directory.extend([0; 6]);
        directory.extend((0o100_644_u32 << 16).to_le_bytes());
        directory.extend(offset.to_le_bytes());
        directory.extend(name.as_bytes());
    }
    let (start, size) = (archive.len() as u32, directory.len() as u32);
    let count = files.len() as u16;
    archive.extend(directory);
    archive.extend(0x0605_4b50_u32.to_le_bytes());
    archive.extend([0; 4]);
    for short in [count, count] {
        archive.extend(short.to_le_bytes());
    }
    archive.extend(size.to_le_bytes());
    archive.extend(start.to_le_bytes());
    archive.extend([0; 2]);
    archive
}
