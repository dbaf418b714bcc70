//! Filters of attributes [EXT_meshopt_compression, appendix B; COLOR: KHR_meshopt_compression], in place.

/// Undoes a filter on elements of `stride` bytes; `None` if the filter does not apply to them.
pub fn apply(filter: &str, bytes: &mut [u8], stride: usize) -> Option<()> {
    match (filter, stride) {
        ("NONE", _) => {}
        ("OCTAHEDRAL", 4) => {
            each(bytes, |e| octahedral(e.map(|b| i32::from(b as i8)), 127.0).map(|x| x as u8));
        }
        ("OCTAHEDRAL", 8) => each_of_two(bytes, |e| octahedral(e.map(i32::from), 32767.0).map(|x| x as i16)),
        ("QUATERNION", 8) => each_of_two(bytes, quaternion),
        ("EXPONENTIAL", _) => each(bytes, exponential),
        ("COLOR", 4) => each(bytes, |e| {
            color([i32::from(e[0]), i32::from(e[1] as i8), i32::from(e[2] as i8), i32::from(e[3])], 255.0)
                .map(|x| x as u8)
        }),
        ("COLOR", 8) => each_of_two(bytes, |e| {
            let unsigned = |x: i16| i32::from(x as u16);
            color([unsigned(e[0]), i32::from(e[1]), i32::from(e[2]), unsigned(e[3])], 65535.0)
                .map(|x| x as u16 as i16)
        }),
        _ => return None,
    }
    Some(())
}

/// Changes each element of four bytes.
fn each(bytes: &mut [u8], change: impl Fn([u8; 4]) -> [u8; 4]) {
    bytes.as_chunks_mut::<4>().0.iter_mut().for_each(|element| *element = change(*element));
}

/// Changes each element of four numbers of two bytes.
fn each_of_two(bytes: &mut [u8], change: impl Fn([i16; 4]) -> [i16; 4]) {
    for element in bytes.as_chunks_mut::<8>().0 {
        let numbers = std::array::from_fn(|at| i16::from_le_bytes([element[2 * at], element[2 * at + 1]]));
        for (at, number) in change(numbers).into_iter().enumerate() {
            element[2 * at..2 * at + 2].copy_from_slice(&number.to_le_bytes());
        }
    }
}

/// Rounds a number, halves away from zero.
fn rounded(number: f32) -> i32 {
    (number + if number >= 0.0 { 0.5 } else { -0.5 }) as i32
}

/// Unit vector times `largest`, from its position on an octahedron whose size is the third number; the fourth stays.
fn octahedral([x, y, one, w]: [i32; 4], largest: f32) -> [i32; 4] {
    let (x, y) = (x as f32, y as f32);
    let z = one as f32 - x.abs() - y.abs();
    // The lower half is mapped outwards.
    let fold = z.min(0.0);
    let x = x + if x >= 0.0 { fold } else { -fold };
    let y = y + if y >= 0.0 { fold } else { -fold };
    let scale = largest / (x * x + y * y + z * z).sqrt();
    [rounded(x * scale), rounded(y * scale), rounded(z * scale), w]
}

/// Unit quaternion from three components without the largest; the last number holds its index and the scale.
fn quaternion([x, y, z, last]: [i16; 4]) -> [i16; 4] {
    let scale = f32::from(last | 3);
    let [x, y, z] = [x, y, z].map(f32::from);
    let w = (2.0 * scale * scale - x * x - y * y - z * z).max(0.0).sqrt();
    let share = 32767.0 / 2.0_f32.sqrt() / scale;
    let index = usize::from(last as u16 & 3);
    let mut turned = [0; 4];
    for (step, number) in [(1, x), (2, y), (3, z), (0, w)] {
        turned[(index + step) & 3] = rounded(number * share) as i16;
    }
    turned
}

/// Float from a mantissa of 24 bits and an exponent of 8.
fn exponential(bytes: [u8; 4]) -> [u8; 4] {
    let word = i32::from_le_bytes(bytes);
    let power = f32::from_bits((((word >> 24) + 127) as u32) << 23);
    (power * ((word << 8) >> 8) as f32).to_le_bytes()
}

/// Red, green, blue and alpha, from brightness and two differences. The highest bit of alpha gives the quantisation of all.
fn color([brightness, orange, green, alpha]: [i32; 4], largest: f32) -> [i32; 4] {
    let mut scale = alpha;
    for shift in [1, 2, 4, 8] {
        scale |= scale >> shift;
    }
    let alpha = ((alpha << 1) & scale) | (alpha & 1);
    let colors = [brightness + orange - green, brightness + green, brightness - orange - green, alpha];
    colors.map(|number| rounded(number as f32 * (largest / scale as f32)))
}
