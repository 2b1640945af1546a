//! VTK XML PolyData (`.vtp`): points, triangles or vertices, and arrays on the points.
//!
//! ```text
//! <VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">
//!   <PolyData> ... <DataArray type="Float32" Name="..." NumberOfComponents="3" format="appended" offset="0"/> ...
//!   <AppendedData encoding="raw">_ [UInt64 bytes][values] [UInt64 bytes][values] ... </AppendedData>
//! ```
//! The VTK file formats document ("VTK XML Formats", docs.vtk.org) has the rules: offsets count from the byte behind the underscore, and each
//! block begins with the number of its bytes.

use std::fmt::Write;

/// Array of one value or vector a point.
pub(super) struct PointArray {
    pub(super) name: &'static str,
    pub(super) components: usize,
    pub(super) values: Vec<f32>,
}

/// Cells of the mesh.
pub(super) enum Cells<'a> {
    /// One vertex a point.
    Vertices,
    /// Triangles by the numbers of their corners.
    Triangles(&'a [[u32; 3]]),
}

/// One file.
pub(super) struct PolyData<'a> {
    /// Positions, m.
    pub(super) points: Vec<[f32; 3]>,
    pub(super) cells: Cells<'a>,
    pub(super) arrays: Vec<PointArray>,
    pub(super) time_s: f64,
}

/// Blocks of raw values, and the tags that name them.
#[derive(Default)]
struct Appended {
    bytes: Vec<u8>,
}

impl Appended {
    /// Appends `values` and returns the tag of the array.
    fn tag(
        &mut self,
        kind: &str,
        name: &str,
        components: usize,
        values: impl Iterator<Item = [u8; N4]>,
    ) -> String {
        let offset = self.bytes.len();
        self.bytes.extend_from_slice(&0_u64.to_le_bytes());
        values.for_each(|value| self.bytes.extend_from_slice(&value));
        let length = (self.bytes.len() - offset - 8) as u64;
        self.bytes[offset..offset + 8].copy_from_slice(&length.to_le_bytes());
        format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"appended\" \
             offset=\"{offset}\"/>\n"
        )
    }
}

/// Bytes of a value: all are f32 or i32.
const N4: usize = 4;

impl PolyData<'_> {
    /// Returns the bytes of the file.
    pub(super) fn to_vtp(&self) -> Vec<u8> {
        let count = self.points.len();
        let (corners, of): (Vec<i32>, i32) = match self.cells {
            Cells::Vertices => ((0..count as i32).collect(), 1),
            Cells::Triangles(all) => (all.iter().flatten().map(|&corner| corner.cast_signed()).collect(), 3),
        };
        let ends = (1..=corners.len() as i32 / of).map(|cell| (of * cell).to_le_bytes());
        let (tag, cells) = (if of == 1 { "Verts" } else { "Polys" }, corners.len() as i32 / of);
        let mut appended = Appended::default();
        let mut head = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" \
             header_type=\"UInt64\">\n<PolyData>\n<FieldData>\n<DataArray type=\"Float64\" Name=\"TimeValue\" \
             NumberOfTuples=\"1\" format=\"ascii\">{}</DataArray>\n</FieldData>\n\
             <Piece NumberOfPoints=\"{count}\" NumberOfVerts=\"{}\" NumberOfLines=\"0\" NumberOfStrips=\"0\" \
             NumberOfPolys=\"{}\">\n<Points>\n",
            self.time_s,
            if of == 1 { cells } else { 0 },
            if of == 3 { cells } else { 0 },
        );
        let positions = self.points.iter().flatten().map(|x| x.to_le_bytes());
        head += &appended.tag("Float32", "Points", 3, positions);
        // Writing into a string cannot fail.
        let _ = write!(head, "</Points>\n<{tag}>\n");
        head += &appended.tag("Int32", "connectivity", 1, corners.iter().map(|corner| corner.to_le_bytes()));
        head += &appended.tag("Int32", "offsets", 1, ends);
        let _ = write!(head, "</{tag}>\n<PointData>\n");
        for array in &self.arrays {
            let values = array.values.iter().map(|value| value.to_le_bytes());
            head += &appended.tag("Float32", array.name, array.components, values);
        }
        head += "</PointData>\n</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_";
        [head.as_bytes(), &appended.bytes, b"\n</AppendedData>\n</VTKFile>\n"].concat()
    }
}
