//! Modes TRIANGLES and INDICES [EXT_meshopt_compression, appendix A].

/// The most recent vertices and edges, in ring buffers of 16.
struct Recent {
    vertices: [u32; 16],
    edges: [(u32, u32); 16],
    next_vertex: usize,
    next_edge: usize,
}

impl Default for Recent {
    fn default() -> Recent {
        Recent { vertices: [u32::MAX; 16], edges: [(u32::MAX, u32::MAX); 16], next_vertex: 0, next_edge: 0 }
    }
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

/// Reader of the numbers behind the codes.
struct Reader<'a> {
    data: &'a [u8],
    /// Last index that was encoded by a difference.
    last: u32,
}

impl Reader<'_> {
    fn byte(&mut self) -> Option<u8> {
        let (&byte, rest) = self.data.split_first()?;
        self.data = rest;
        Some(byte)
    }

    /// Reads a number in groups of seven bits, the lowest first; five groups at most.
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

/// Difference modulo 2^32 whose lowest bit is the sign.
fn signed(number: u32) -> u32 {
    (number >> 1) ^ 0_u32.wrapping_sub(number & 1)
}

fn push_index(decoded: &mut Vec<u8>, index: u32, size: usize) {
    decoded.extend(&index.to_le_bytes()[..size]);
}

/// Decodes `count` indices of two or four bytes, three a triangle; `None` for a damaged stream.
pub fn triangles(bytes: &[u8], count: usize, size: usize) -> Option<Vec<u8>> {
    let (&header, data) = bytes.split_first()?;
    let version = header & 15;
    if header & 0xF0 != 0xE0 || version > 1 {
        return None;
    }
    let (codes, data) = data.split_at_checked(count / 3)?;
    let (data, table) = data.split_at_checked(data.len().checked_sub(16)?)?;
    let mut decoder = TriangleDecoder {
        reader: Reader { data, last: 0 },
        recent: Recent::default(),
        next: 0,
        recent_codes: if version == 0 { 15 } else { 13 },
    };
    let mut decoded = Vec::with_capacity(codes.len() * 3 * size);
    for &code in codes {
        let (high, low) = (code >> 4, code & 15);
        let corners = match (high, low) {
            (15, 14 | 15) => decoder.triangle_by_byte(low == 15)?,
            (15, _) => decoder.triangle_by_table(table[usize::from(low)]),
            _ => decoder.triangle_on_edge(usize::from(high), low)?,
        };
        corners.into_iter().for_each(|index| push_index(&mut decoded, index, size));
    }
    decoder.reader.data.is_empty().then_some(decoded)
}

/// State between triangles.
struct TriangleDecoder<'a> {
    reader: Reader<'a>,
    recent: Recent,
    /// Next new vertex.
    next: u32,
    /// Codes below this number are recent vertices.
    recent_codes: u8,
}

impl TriangleDecoder<'_> {
    /// Returns the next new vertex.
    fn fresh(&mut self) -> u32 {
        let vertex = self.next;
        self.next = vertex.wrapping_add(1);
        vertex
    }

    /// Triangle on a recent edge. Its third vertex is new, recent, next to the last index, or any.
    fn triangle_on_edge(&mut self, edge: usize, code: u8) -> Option<[u32; 3]> {
        let (a, b) = self.recent.edge(1 + edge);
        let is_recent = (1..self.recent_codes).contains(&code);
        let c = match code {
            0 => self.fresh(),
            code if is_recent => self.recent.vertex(1 + usize::from(code)),
            15 => self.reader.index()?,
            code => {
                let step = if code == 13 { u32::MAX } else { 1 };
                self.reader.last = self.reader.last.wrapping_add(step);
                self.reader.last
            }
        };
        if !is_recent {
            self.recent.push_vertex(c);
        }
        self.recent.push_edges(&[(c, b), (a, c)]);
        Some([a, b, c])
    }

    /// Triangle of a new vertex and of two new or recent vertices.
    fn triangle_by_table(&mut self, code: u8) -> [u32; 3] {
        let a = self.fresh();
        let codes = [code >> 4, code & 15];
        // Look up recent vertices before any of these is pushed
        let [b, c] = codes.map(|code| self.fresh_or_recent(code));
        self.recent.push_vertex(a);
        for (vertex, _) in [b, c].into_iter().zip(codes).filter(|(_, code)| *code == 0) {
            self.recent.push_vertex(vertex);
        }
        self.recent.push_edges(&[(b, a), (c, b), (a, c)]);
        [a, b, c]
    }

    /// Triangle of new, recent or arbitrary vertices, by the next byte; the first is new or arbitrary.
    fn triangle_by_byte(&mut self, first_is_any: bool) -> Option<[u32; 3]> {
        let code = self.reader.byte()?;
        if code == 0 {
            self.next = 0;
        }
        let codes = [if first_is_any { 15 } else { 0 }, code >> 4, code & 15];
        // Look up recent vertices before any of these is pushed, then read the others
        let mut corners = codes.map(|code| if code == 15 { 0 } else { self.fresh_or_recent(code) });
        for (corner, _) in corners.iter_mut().zip(codes).filter(|(_, code)| *code == 15) {
            *corner = self.reader.index()?;
        }
        for (corner, _) in corners.into_iter().zip(codes).filter(|(_, code)| matches!(code, 0 | 15)) {
            self.recent.push_vertex(corner);
        }
        let [a, b, c] = corners;
        self.recent.push_edges(&[(b, a), (c, b), (a, c)]);
        Some(corners)
    }

    fn fresh_or_recent(&mut self, code: u8) -> u32 {
        if code == 0 { self.fresh() } else { self.recent.vertex(usize::from(code)) }
    }
}

/// Decodes `count` indices of two or four bytes; `None` for a damaged stream.
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
