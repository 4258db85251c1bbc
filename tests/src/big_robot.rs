//! A full-size robot, written when a test needs one: 25 links with detailed meshes, half of them COLLADA with shared
//! vertices and smooth normals, half of them binary STL, about 250,000 triangles and 17 MB of files.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::io;
use std::path::Path;

/// A joint that turns a link about the z axis of its own frame.
#[derive(Clone, Debug)]
pub struct BigJoint {
    /// The link that it is attached to.
    pub parent: String,
    /// The link that it moves, whose mesh surrounds the joint.
    pub child: String,
    /// Position of the child's frame in the parent's, in metres.
    pub origin_m: [f64; 3],
}

/// Triangles of the smallest and the largest mesh.
const TRIANGLES: [usize; 2] = [5_000, 15_000];

/// Writes the package `big_robot` with its meshes and `robot.urdf` below a folder.
///
/// # Errors
/// Those of writing the files.
pub fn write(folder: &Path) -> io::Result<Vec<BigJoint>> {
    let package = folder.join("big_robot");
    std::fs::create_dir_all(package.join("meshes"))?;
    std::fs::write(package.join("package.xml"), "<package><name>big_robot</name></package>\n")?;
    let joints = joints();
    let links: Vec<&str> = std::iter::once("base").chain(joints.iter().map(|joint| joint.child.as_str())).collect();
    let mut urdf =
        String::from("<robot name=\"big\">\n<material name=\"steel\"><color rgba=\"0.6 0.65 0.7 1\"/></material>\n");
    for (i, link) in links.iter().enumerate() {
        let [fewest, most] = TRIANGLES;
        let triangles = fewest + (most - fewest) * i / (links.len() - 1);
        let (radius_m, length_m) = if i == 0 { (0.25, 0.2) } else { (0.07, 0.22) };
        let surface = Surface::new(triangles, radius_m, length_m, i);
        let file = if i % 2 == 0 { format!("{link}.dae") } else { format!("{link}.stl") };
        let bytes = if i % 2 == 0 { surface.collada().into_bytes() } else { surface.stl() };
        std::fs::write(package.join("meshes").join(&file), bytes)?;
        let shape = format!("<geometry><mesh filename=\"package://big_robot/meshes/{file}\"/></geometry>");
        let _ = writeln!(
            urdf,
            "<link name=\"{link}\"><visual>{shape}<material name=\"steel\"/></visual><collision>{shape}</collision></link>"
        );
    }
    for BigJoint { parent, child, origin_m: [x, y, z] } in &joints {
        let _ = writeln!(
            urdf,
            "<joint name=\"{child}_joint\" type=\"revolute\"><parent link=\"{parent}\"/><child link=\"{child}\"/>\
             <origin xyz=\"{x} {y} {z}\"/><axis xyz=\"0 0 1\"/>\
             <limit lower=\"-3\" upper=\"3\" effort=\"50\" velocity=\"2\"/></joint>"
        );
    }
    urdf.push_str("</robot>\n");
    std::fs::write(package.join("robot.urdf"), urdf)?;
    Ok(joints)
}

/// A base with a column, a head and two arms.
fn joints() -> Vec<BigJoint> {
    let mut joints = Vec::new();
    let mut chain = |root: &str, name: &str, count: usize, first: [f64; 3], next: [f64; 3]| {
        let mut parent = root.to_owned();
        for i in 0..count {
            let child = format!("{name}_{i}");
            let origin_m = if i == 0 { first } else { next };
            joints.push(BigJoint { parent, child: child.clone(), origin_m });
            parent = child;
        }
    };
    chain("base", "torso", 4, [0.0, 0.0, 0.2], [0.0, 0.0, 0.2]);
    chain("torso_3", "head", 4, [0.0, 0.0, 0.22], [0.03, 0.0, 0.08]);
    chain("torso_3", "left", 8, [0.0, 0.2, 0.1], [0.06, 0.08, -0.05]);
    chain("torso_3", "right", 8, [0.0, -0.2, 0.1], [0.06, -0.08, -0.05]);
    joints
}

/// A bumpy surface around the z axis.
struct Surface {
    rings: usize,
    segments: usize,
    radius_m: f64,
    length_m: f64,
    bumps: f64,
}

impl Surface {
    fn new(triangles: usize, radius_m: f64, length_m: f64, bumps: usize) -> Self {
        let side = ((triangles / 2) as f64).sqrt().round() as usize;
        Self { rings: side, segments: side, radius_m, length_m, bumps: 3.0 + (bumps % 5) as f64 }
    }

    fn point(&self, ring: usize, segment: usize) -> [f64; 3] {
        let (t, angle) = (ring as f64 / self.rings as f64, TAU * segment as f64 / self.segments as f64);
        let profile = (std::f64::consts::PI * t).sin().max(0.0).sqrt();
        let radius_m = self.radius_m * profile * (1.0 + 0.08 * (self.bumps * angle).cos() * (TAU * 3.0 * t).sin());
        [radius_m * angle.cos(), radius_m * angle.sin(), self.length_m * (t - 0.5)]
    }

    /// The corners of each triangle, as rings and segments.
    fn triangles(&self) -> impl Iterator<Item = [(usize, usize); 3]> + '_ {
        (0..self.rings).flat_map(move |ring| {
            (0..self.segments).flat_map(move |segment| {
                let next = (segment + 1) % self.segments;
                let [a, b, c, d] = [(ring, segment), (ring, next), (ring + 1, next), (ring + 1, segment)];
                [[a, b, c], [a, c, d]]
            })
        })
    }

    /// The outward normal, from the neighbouring points.
    fn normal(&self, ring: usize, segment: usize) -> [f64; 3] {
        let around = |step: usize| self.point(ring, (segment + step) % self.segments);
        let along = [self.point((ring + 1).min(self.rings), segment), self.point(ring.saturating_sub(1), segment)];
        let normal = cross(difference(around(1), around(self.segments - 1)), difference(along[0], along[1]));
        let up = if ring == 0 { -1.0 } else { 1.0 };
        unit(normal).unwrap_or([0.0, 0.0, up])
    }

    fn stl(&self) -> Vec<u8> {
        let triangles: Vec<_> = self.triangles().collect();
        let mut bytes = vec![b' '; 80];
        bytes.extend((triangles.len() as u32).to_le_bytes());
        for corners in triangles {
            let [a, b, c] = corners.map(|(ring, segment)| self.point(ring, segment));
            let normal = unit(cross(difference(b, a), difference(c, a))).unwrap_or_default();
            let numbers = [normal, a, b, c].concat().into_iter();
            bytes.extend(numbers.flat_map(|number| (number as f32).to_le_bytes()));
            bytes.extend([0, 0]);
        }
        bytes
    }

    fn collada(&self) -> String {
        let vertices = || (0..=self.rings).flat_map(|ring| (0..self.segments).map(move |segment| (ring, segment)));
        let list = |id: &str, of: &dyn Fn(usize, usize) -> [f64; 3]| {
            let mut numbers = String::new();
            let mut count = 0;
            for (ring, segment) in vertices() {
                let [x, y, z] = of(ring, segment);
                let _ = write!(numbers, "{x:.6} {y:.6} {z:.6} ");
                count += 1;
            }
            format!(
                "<source id=\"{id}\"><float_array id=\"{id}-array\" count=\"{}\">{numbers}</float_array><technique_common>\
                 <accessor source=\"#{id}-array\" count=\"{count}\" stride=\"3\"><param name=\"X\" type=\"float\"/>\
                 <param name=\"Y\" type=\"float\"/><param name=\"Z\" type=\"float\"/></accessor></technique_common></source>\n",
                count * 3
            )
        };
        let (positions, normals) = (
            list("p", &|ring, segment| self.point(ring, segment)),
            list("n", &|ring, segment| self.normal(ring, segment)),
        );
        let mut indices = String::new();
        let mut count = 0;
        for corners in self.triangles() {
            for (ring, segment) in corners {
                let index = ring * self.segments + segment;
                let _ = write!(indices, "{index} {index} ");
            }
            count += 1;
        }
        format!(
            "<?xml version=\"1.0\"?><COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\">\n\
             <asset><unit meter=\"1\" name=\"meter\"/><up_axis>Z_UP</up_axis></asset>\n\
             <library_effects><effect id=\"e\"><profile_COMMON><technique sid=\"c\"><phong><diffuse><color>0.8 0.35 0.1 1\
             </color></diffuse></phong></technique></profile_COMMON></effect></library_effects>\n\
             <library_materials><material id=\"m\"><instance_effect url=\"#e\"/></material></library_materials>\n\
             <library_geometries><geometry id=\"g\"><mesh>{positions}{normals}\
             <vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices>\n\
             <triangles count=\"{count}\" material=\"s\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/>\
             <input semantic=\"NORMAL\" source=\"#n\" offset=\"1\"/><p>{indices}</p></triangles></mesh></geometry>\
             </library_geometries>\n\
             <library_visual_scenes><visual_scene id=\"s0\"><node><instance_geometry url=\"#g\"><bind_material>\
             <technique_common><instance_material symbol=\"s\" target=\"#m\"/></technique_common></bind_material>\
             </instance_geometry></node></visual_scene></library_visual_scenes>\n\
             <scene><instance_visual_scene url=\"#s0\"/></scene></COLLADA>\n"
        )
    }
}

fn difference(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| a[i] - b[i])
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    (length > 1e-12).then(|| v.map(|x| x / length))
}
