//! Static memory of a program: its writable sections but the stack, from the section headers of an ELF file
//! of 32 bits, little-endian.

use super::Failure;

/// Prints the bytes of every section that is writable and loaded, the stack's left out.
pub(crate) fn run(path: &str) -> Result<bool, Failure> {
    let file = std::fs::read(path).map_err(|error| format!("{path}: {error}"))?;
    let bytes = writable(&file).ok_or_else(|| format!("{path} is no ELF file of 32 bits"))?;
    println!("{bytes}");
    Ok(true)
}

/// Section flags: writable and in memory.
const WRITE_ALLOC: u32 = 0b11;

fn writable(file: &[u8]) -> Option<u32> {
    let u32_at = |at: usize| file.get(at..)?.first_chunk().map(|bytes| u32::from_le_bytes(*bytes));
    let u16_at = |at: usize| file.get(at..)?.first_chunk().map(|bytes| u16::from_le_bytes(*bytes) as usize);
    if file.get(..6)? != b"\x7fELF\x01\x01" {
        return None;
    }
    let (table, size, count, names) = (u32_at(32)? as usize, u16_at(46)?, u16_at(48)?, u16_at(50)?);
    let names = u32_at(table + names * size + 16)? as usize;
    let mut sum = 0;
    for header in (0..count).map(|index| table + index * size) {
        let name = file.get(names + u32_at(header)? as usize..)?;
        let flags = u32_at(header + 8)?;
        if flags & WRITE_ALLOC == WRITE_ALLOC && !name.starts_with(b".stack\0") {
            sum += u32_at(header + 20)?;
        }
    }
    Some(sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn writable_sections_are_summed_without_the_stack() {
        let mut file = vec![0; 52];
        file[..6].copy_from_slice(b"\x7fELF\x01\x01");
        file[32] = 52 + 24;
        (file[46], file[48], file[50]) = (40, 4, 3);
        file.extend(b".text\0.bss\0.stack\0");
        file.resize(76, 0);
        for (name, flags, at, size) in
            [(0_u32, 0b110_u32, 0_u32, 900_u32), (6, 3, 0, 40), (11, 3, 0, 64), (0, 0, 52, 24)]
        {
            for word in [name, 1, flags, 0, at, size, 0, 0, 0, 0] {
                file.extend(word.to_le_bytes());
            }
        }
        assert_eq!(writable(&file), Some(40));
        assert_eq!(writable(b"no ELF"), None);
    }
}
