//! Where a stream's requests stand, held against where the table says that they may (RISpec 3.2, sections 4 and 5).
//!
//! What stands elsewhere is warned of, once for each request, and made all the same; options within the world are not, which
//! belong to the image that is under way. A stream may be the inside of a scene alone,
//! which is read within another's world; so what may stand in a world alone is misplaced only if the stream has a world of its own.
//!
//! Blocks nest (RISpec 4 and 6.3): one that another's end ends with it is warned of, as are requests of two kinds in a motion block.

use crate::requests::{Bracket, Request, Stands};
use std::path::{Path, PathBuf};

/// How far a stream has come.
#[derive(Clone, Copy, Default, PartialEq)]
enum World {
    #[default]
    Before,
    Within,
    After,
}

/// Line and column, from 1.
type Spot = (usize, usize);

/// A block that is open.
struct Block {
    begin: Request,
    /// The index of its file, and where it begins there.
    file: usize,
    spot: Spot,
    /// Of a motion block, its first request.
    first: Option<Request>,
}

/// Where a stream and the archives within it are.
#[derive(Default)]
pub(crate) struct Standing {
    /// Blocks that are open, the outermost first, and the files that they stand in.
    open: Vec<Block>,
    files: Vec<PathBuf>,
    /// Pairs of requests that were warned of as not nested, or not of one kind.
    crossed: Vec<(Request, Option<Request>)>,
    world: World,
    /// Objects that are open, whose gprims may be made before a world.
    objects: usize,
    /// Requests that were found misplaced.
    misplaced: Vec<Request>,
    /// What to warn of if a world begins: requests before it that may stand within one alone.
    early: Vec<String>,
}

impl Standing {
    /// Note a request at a place of a file. What is wrong with where it stands is added to the warnings. Answers whether it is to
    /// be made: an option within the world is not.
    #[inline]
    pub(crate) fn note(&mut self, request: Request, path: &Path, spot: Spot, warnings: &mut Vec<String>) -> bool {
        let row = request.row();
        if self.open.last().is_some_and(|block| block.begin == Request::MotionBegin) && breaks_motion(request) {
            self.broken(request, path, spot, warnings);
        }
        if row.bracket != Bracket::Alone {
            self.bracket(request, path, spot, warnings);
            return true;
        }
        if self.open.last().is_some_and(|block| block.begin == Request::MotionBegin) {
            self.moves(request, path, spot, warnings);
        }
        let [stands, expected] = match (row.stands, self.world) {
            (Stands::BeforeWorld, World::Within) => ["between WorldBegin and WorldEnd", "before WorldBegin"],
            (Stands::InWorld, World::Before) if self.objects == 0 => {
                ["before WorldBegin", "between WorldBegin and WorldEnd"]
            }
            (Stands::InWorld, World::After) if self.objects == 0 => {
                ["after WorldEnd", "between WorldBegin and WorldEnd"]
            }
            _ => return true,
        };
        let is_made = row.stands != Stands::BeforeWorld;
        if !self.misplaced.contains(&request) {
            self.misplaced.push(request);
            let refused = if is_made { "" } else { "; it is passed over" };
            let place = placed(path, spot);
            let message = format!("{place}: `{}` stands {stands}, expected {expected}{refused}", row.name);
            if self.world == World::Before { self.early.push(message) } else { warnings.push(message) }
        }
        is_made
    }

    /// Note a request that begins or ends a block. What ends a block that was not begun is not asked here.
    fn bracket(&mut self, request: Request, path: &Path, spot: Spot, warnings: &mut Vec<String>) {
        match request {
            Request::WorldBegin => {
                self.world = World::Within;
                warnings.append(&mut self.early);
            }
            Request::WorldEnd => self.world = World::After,
            Request::ObjectBegin => self.objects += 1,
            Request::ObjectEnd => self.objects = self.objects.saturating_sub(1),
            _ => {}
        }
        if end_of(request).is_some() {
            let file = self.file(path);
            self.open.push(Block { begin: request, file, spot, first: None });
        } else if let Some(at) = self.open.iter().rposition(|block| end_of(block.begin) == Some(request)) {
            let name = request.name();
            let until = || format!(" before the `{name}` at {}", placed(path, spot));
            self.cut(at + 1, Some(request), until, warnings);
            self.open.truncate(at);
        } else if matches!(request, Request::AttributeEnd | Request::SolidEnd)
            && !self.crossed.contains(&(request, None))
        {
            self.crossed.push((request, None));
            let begin = if request == Request::SolidEnd { Request::SolidBegin } else { Request::AttributeBegin };
            warnings.push(format!("{}: `{}` without `{}`", placed(path, spot), request.name(), begin.name()));
        }
    }

    /// Warn of the blocks from this one on, which have no end of their own; `until` says where they are ended.
    fn cut(&mut self, from: usize, end: Option<Request>, until: impl Fn() -> String, warnings: &mut Vec<String>) {
        for block in &self.open[from..] {
            if self.crossed.contains(&(block.begin, end)) {
                continue;
            }
            self.crossed.push((block.begin, end));
            let (place, name) = (placed(&self.files[block.file], block.spot), block.begin.name());
            let missing = end_of(block.begin).map_or("end", |end| end.name());
            warnings.push(format!("{place}: this `{name}` has no `{missing}`{}", until()));
        }
    }

    /// The blocks that are open where the stream ends.
    pub(crate) fn end(&mut self) -> Vec<String> {
        let mut warnings = vec![];
        self.cut(0, None, String::new, &mut warnings);
        self.open.clear();
        warnings
    }

    /// Note a request in a motion block, whose requests are to be the same one at several times (RISpec 6.3).
    fn moves(&mut self, request: Request, path: &Path, spot: Spot, warnings: &mut Vec<String>) {
        let Some(block) = self.open.last_mut() else { return };
        let first = *block.first.get_or_insert(request);
        if first != request && !self.crossed.contains(&(first, Some(request))) {
            self.crossed.push((first, Some(request)));
            let [first, other] = [first, request].map(|request| request.name());
            let place = placed(path, spot);
            warnings
                .push(format!("{place}: `{other}` in a motion block of `{first}`, expected one request at all times"));
        } else if !self.crossed.contains(&(request, Some(request)))
            && let Some(instead) = instead_of_motion(request)
        {
            self.crossed.push((request, Some(request)));
            warnings.push(format!("{}: `{}` in a motion block: {instead}", placed(path, spot), request.name()));
        }
    }

    /// Note a request in a motion block that begins or ends another.
    fn broken(&mut self, request: Request, path: &Path, spot: Spot, warnings: &mut Vec<String>) {
        if !self.crossed.contains(&(Request::MotionBegin, Some(request))) {
            self.crossed.push((Request::MotionBegin, Some(request)));
            let place = placed(path, spot);
            warnings.push(format!("{place}: `{}` in a motion block, expected what moves alone", request.name()));
        }
    }

    /// The index of a file.
    fn file(&mut self, path: &Path) -> usize {
        self.files.iter().rposition(|known| known == path).unwrap_or_else(|| {
            self.files.push(path.into());
            self.files.len() - 1
        })
    }
}

/// What becomes of a request that does not move; nothing if it does. Transformations, primitives, colours and shaders may move
/// by the specification (table 6.1).
fn instead_of_motion(request: Request) -> Option<&'static str> {
    use Request::*;
    match request {
        Color | Opacity => None,
        Surface | Displacement | Atmosphere | Interior | Exterior | Deformation | LightSource | AreaLightSource
        | Projection | Bound | Detail => Some("the first holds, it does not move here"),
        Identity | Transform | ConcatTransform | Perspective | Translate | Rotate | Scale | Skew
        | CoordSysTransform => None,
        ObjectInstance => Some("an instance moves with the transformation alone, and one is drawn at each time"),
        _ if request.row().stands == Stands::InWorld => None,
        _ => Some("it may not move"),
    }
}

/// Whether a request begins or ends a block that has no place within a motion block. What ends one that is around it ends the motion
/// block, too, and is said to.
fn breaks_motion(request: Request) -> bool {
    use Request::*;
    matches!(request, AttributeBegin | TransformBegin | SolidBegin | ObjectBegin | FrameBegin | WorldBegin)
}

/// A place as it is written.
fn placed(path: &Path, (line, column): Spot) -> String {
    format!("{}:{line}:{column}", path.display())
}

/// What ends a block that a request begins, if it begins one that is kept here: archives and conditions are the reader's.
fn end_of(begin: Request) -> Option<Request> {
    Some(match begin {
        Request::FrameBegin => Request::FrameEnd,
        Request::WorldBegin => Request::WorldEnd,
        Request::AttributeBegin => Request::AttributeEnd,
        Request::TransformBegin => Request::TransformEnd,
        Request::ObjectBegin => Request::ObjectEnd,
        Request::SolidBegin => Request::SolidEnd,
        Request::MotionBegin => Request::MotionEnd,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use crate::files::Files;
    use crate::params::Params;
    use crate::reader::read;
    use crate::ri::{Ri, RiResult};
    use std::path::Path;

    /// Keeps warnings, and the calls that are made.
    #[derive(Default)]
    struct Heard(Vec<String>, Vec<&'static str>);

    impl Ri for Heard {
        fn world_begin(&mut self) -> RiResult {
            Ok(())
        }
        fn world_end(&mut self) -> RiResult {
            Ok(())
        }
        fn object_begin(&mut self, _: &str) -> RiResult {
            Ok(())
        }
        fn object_end(&mut self) -> RiResult {
            Ok(())
        }
        fn color(&mut self, _: [f32; 3]) -> RiResult {
            Ok(())
        }
        fn opacity(&mut self, _: [f32; 3]) -> RiResult {
            Ok(())
        }
        fn surface(&mut self, _: &str, _: Params) -> RiResult {
            Ok(())
        }
        fn attribute_begin(&mut self) -> RiResult {
            Ok(())
        }
        fn attribute_end(&mut self) -> RiResult {
            Ok(())
        }
        fn transform_begin(&mut self) -> RiResult {
            Ok(())
        }
        fn solid_end(&mut self) -> RiResult {
            Ok(())
        }
        fn motion_begin(&mut self, _: Vec<f32>) -> RiResult {
            Ok(())
        }
        fn motion_end(&mut self) -> RiResult {
            Ok(())
        }
        fn translate(&mut self, _: [f32; 3]) -> RiResult {
            Ok(())
        }
        fn rotate(&mut self, _: f32, _: [f32; 3]) -> RiResult {
            Ok(())
        }
        fn format(&mut self, _: i32, _: i32, _: f32) -> RiResult {
            self.1.push("Format");
            Ok(())
        }
        fn points(&mut self, _: Params) -> RiResult {
            self.1.push("Points");
            Ok(())
        }
        fn warn(&mut self, message: String) {
            self.0.push(message);
        }
    }

    fn heard(text: &str) -> Heard {
        let mut heard = Heard::default();
        read(Path::new("t.rib"), text.as_bytes(), &Files::default(), &mut heard, &mut |_, _| Ok(None)).unwrap();
        heard
    }

    #[test]
    fn a_misplaced_request_is_said_once_and_made() {
        let Heard(said, made) = heard("WorldBegin\n Format 1 1 1 Format 2 2 1\nWorldEnd Points Points");
        let expected = [
            "t.rib:2:2: `Format` stands between WorldBegin and WorldEnd, expected before WorldBegin; it is passed over",
            "t.rib:3:10: `Points` stands after WorldEnd, expected between WorldBegin and WorldEnd",
        ];
        assert_eq!(said, expected);
        assert_eq!(made, ["Points", "Points"]);
        let Heard(said, _) = heard("Color 1 1 1 Points Points WorldBegin Points WorldEnd");
        assert_eq!(said, ["t.rib:1:13: `Points` stands before WorldBegin, expected between WorldBegin and WorldEnd"]);
    }

    #[test]
    fn what_stands_where_it_may_is_not_warned_of() {
        for sound in [
            // Frames, each with its options; attributes anywhere.
            "Format 1 1 1 WorldBegin Color 1 1 1 Points WorldEnd Color 1 1 1 Format 2 2 1 WorldBegin WorldEnd",
            // An object before the world.
            "ObjectBegin 1 Points ObjectEnd WorldBegin WorldEnd",
            // The inside of a scene.
            "Color 1 1 1 Points",
            // Archives of the stream are in the world that reads them.
            "ArchiveBegin \"a\" Points ArchiveEnd WorldBegin ReadArchive \"a\" WorldEnd",
            // What a condition leaves out.
            "WorldBegin IfBegin \"0\" Format 1 1 1 IfEnd WorldEnd",
        ] {
            assert_eq!(heard(sound).0, Vec::<String>::new(), "{sound}");
        }
        let within = "ArchiveBegin \"a\" Format 1 1 1 ArchiveEnd WorldBegin ReadArchive \"a\" WorldEnd";
        assert_eq!(heard(within).0.len(), 1);
    }

    #[test]
    fn blocks_nest() {
        let said = |text: &str| heard(text).0;
        let inner = "t.rib:2:1: this `AttributeBegin` has no `AttributeEnd`";
        assert_eq!(
            said("WorldBegin\nAttributeBegin\nWorldEnd"),
            [format!("{inner} before the `WorldEnd` at t.rib:3:1")]
        );
        assert_eq!(said("Color 1 1 1\nAttributeBegin Points"), [inner]);
        let crossed = said("WorldBegin AttributeBegin TransformBegin AttributeEnd WorldEnd");
        assert_eq!(
            crossed,
            ["t.rib:1:27: this `TransformBegin` has no `TransformEnd` before the `AttributeEnd` at t.rib:1:42"]
        );
        assert_eq!(said("AttributeBegin SolidEnd AttributeEnd"), ["t.rib:1:16: `SolidEnd` without `SolidBegin`"]);
        // A fault that comes again is said once, and what a block of another file lacks with that file's name.
        assert_eq!(said(&"AttributeBegin TransformBegin AttributeEnd ".repeat(3)).len(), 1);
        assert_eq!(said("WorldBegin"), ["t.rib:1:1: this `WorldBegin` has no `WorldEnd`"]);
    }

    #[test]
    fn a_motion_block_has_one_request() {
        let said = |text: &str| heard(text).0;
        let mixed = said("MotionBegin [0 1] Translate 0 0 0 Rotate 9 0 0 1 MotionEnd");
        assert_eq!(mixed, ["t.rib:1:35: `Rotate` in a motion block of `Translate`, expected one request at all times"]);
        for request in ["Translate 0 0 0", "Color 1 0 0", "Opacity 1 1 1"] {
            assert!(said(&format!("MotionBegin [0 1] {request} {request} MotionEnd")).is_empty());
        }
        let block = said("MotionBegin [0 1] AttributeBegin Translate 0 0 0 AttributeEnd Translate 0 0 0 MotionEnd");
        assert_eq!(block, ["t.rib:1:19: `AttributeBegin` in a motion block, expected what moves alone"]);
        for (request, what) in [("Surface \"matte\"", "does not move here"), ("Format 1 1 1", "may not move")] {
            let said = said(&format!("MotionBegin [0 1] {request} {request} MotionEnd"));
            let name = request.split(' ').next().unwrap();
            assert_eq!(said.len(), 1, "{said:?}");
            let place = format!("t.rib:1:19: `{name}` in a motion block: ");
            assert!(said[0].starts_with(&place) && said[0].contains(what), "{said:?}");
        }
    }
}
