//! Modes TRIANGLES and INDICES [EXT_meshopt_compression, appendix A].

/// Vertices and edges that were last named, in rings of 16.
struct Recent {
    vertices: [u32; 16],
    edges: [(u32, u32); 16],
    next_vertex: usize,
    next_edge: usize,
}

impl Recent {
    fn vertex(&self, back: usize) -> u32 {
        self.vertices[self.next_vertex.wrapping_sub(back) & 15]
    }

    fn edge(&self, back: usize) -> (u32, u32) {
        self.edges[self.next_edge.wrapping_sub(back) & 15]
    }

    fn push_vertex(&mut self, vertex: u32) {
        self.vertices[self.next_vertex & 15] = vertex;
        self.next_vertex += 1;
    }

    fn push_edges(&mut self, edges: &[(u32, u32)]) {
        for &edge in edges {
            self.edges[self.next_edge & 15] = edge;
            self.next_edge += 1;
        }
    }
}

/// Numbers behind the codes.
struct Reader<'a> {
    data: &'a [u8],
    /// The last index that was given by its difference.
    last: u32,
}

impl Reader<'_> {
    fn byte(&mut self) -> Option<u8> {
        let (&byte, rest) = self.data.split_first()?;
        self.data = rest;
        Some(byte)
    }

    /// Groups of seven bits, the lowest first; five at most.
    fn varint(&mut self) -> Option<u32> {
        let mut number = 0;
        for shift in [0, 7, 14, 21, 28] {
            let byte = self.byte()?;
            number |= u32::from(byte & 127) << shift;
            if byte < 128 {
                break;
            }
        }
        Some(number)
    }

    fn index(&mut self) -> Option<u32> {
        self.last = self.last.wrapping_add(signed(self.varint()?));
        Some(self.last)
    }
}

/// A difference whose lowest bit is its sign, modulo 2^32.
fn signed(number: u32) -> u32 {
    (number >> 1) ^ 0_u32.wrapping_sub(number & 1)
}

fn push_index(decoded: &mut Vec<u8>, index: u32, size: usize) {
    decoded.extend(&index.to_le_bytes()[..size]);
}

/// So many indices of two or four bytes, three a triangle; `None` of a damaged stream.
pub fn triangles(bytes: &[u8], count: usize, size: usize) -> Option<Vec<u8>> {
    let (&header, data) = bytes.split_first()?;
    let version = header & 15;
    if header & 0xF0 != 0xE0 || version > 1 {
        return None;
    }
    let (codes, data) = data.split_at_checked(count / 3)?;
    let (data, table) = data.split_at_checked(data.len().checked_sub(16)?)?;
    let mut reader = Reader { data, last: 0 };
    let mut recent =
        Recent { vertices: [u32::MAX; 16], edges: [(u32::MAX, u32::MAX); 16], next_vertex: 0, next_edge: 0 };
    let coded = if version == 0 { 15 } else { 13 };
    let mut decoded = Vec::with_capacity(codes.len() * 3 * size);
    let mut next = 0_u32;
    let fresh = |next: &mut u32| {
        let vertex = *next;
        *next = next.wrapping_add(1);
        vertex
    };
    for &code in codes {
        let (high, low) = (usize::from(code >> 4), code & 15);
        let [a, b, c] = if high < 15 {
            // On an edge that was there.
            let (a, b) = recent.edge(1 + high);
            let c = if low == 0 {
                let c = fresh(&mut next);
                recent.push_vertex(c);
                c
            } else if low < coded {
                recent.vertex(1 + usize::from(low))
            } else {
                // One less or more than the last, or any.
                let c = match low {
                    15 => reader.index()?,
                    _ => {
                        let step = if low == 13 { u32::MAX } else { 1 };
                        reader.last = reader.last.wrapping_add(step);
                        reader.last
                    }
                };
                recent.push_vertex(c);
                c
            };
            recent.push_edges(&[(c, b), (a, c)]);
            [a, b, c]
        } else {
            // Three vertices: a new one and two by a table, or each as the next byte says.
            let (auxiliary, is_any) = match low {
                14 | 15 => (reader.byte()?, low == 15),
                _ => (table[usize::from(low)], false),
            };
            if low >= 14 && auxiliary == 0 {
                next = 0;
            }
            let codes = [if is_any { 15 } else { 0 }, auxiliary >> 4, auxiliary & 15];
            let mut corners = [0; 3];
            // Those that are there already are looked up before any of these is noted.
            for (corner, code) in corners.iter_mut().zip(codes) {
                *corner = match code {
                    0 => fresh(&mut next),
                    15 if low >= 14 => 0,
                    code => recent.vertex(usize::from(code)),
                };
            }
            for (corner, code) in corners.iter_mut().zip(codes) {
                if code == 15 && low >= 14 {
                    *corner = reader.index()?;
                }
            }
            for (position, (&corner, code)) in corners.iter().zip(codes).enumerate() {
                if position == 0 || code == 0 || (code == 15 && low >= 14) {
                    recent.push_vertex(corner);
                }
            }
            let [a, b, c] = corners;
            recent.push_edges(&[(b, a), (c, b), (a, c)]);
            corners
        };
        [a, b, c].into_iter().for_each(|index| push_index(&mut decoded, index, size));
    }
    reader.data.is_empty().then_some(decoded)
}

/// So many indices of two or four bytes; `None` of a damaged stream.
pub fn sequence(bytes: &[u8], count: usize, size: usize) -> Option<Vec<u8>> {
    let (&header, data) = bytes.split_first()?;
    if header & 0xF0 != 0xD0 || header & 15 > 1 || data.len() < count.checked_add(4)? {
        return None;
    }
    let mut reader = Reader { data: &data[..data.len() - 4], last: 0 };
    let mut last = [0_u32; 2];
    let mut decoded = Vec::with_capacity(count * size);
    for _ in 0..count {
        let number = reader.varint()?;
        let last = &mut last[(number & 1) as usize];
        *last = last.wrapping_add(signed(number >> 1));
        push_index(&mut decoded, *last, size);
    }
    reader.data.is_empty().then_some(decoded)
}
