//! Where a stream's requests stand, held against where the table says that they may (RISpec 3.2, sections 4 and 5).
//!
//! What stands elsewhere is warned of, once for each request, and made all the same; options within the world are not, which
//! belong to the image that is under way. A stream may be the inside of a scene alone,
//! which is read within another's world; so what may stand in a world alone is misplaced only if the stream has a world of its own.

use crate::requests::{Bracket, Request, Stands};

/// How far a stream has come.
#[derive(Clone, Copy, Default, PartialEq)]
enum World {
    #[default]
    Before,
    Within,
    After,
}

/// Where a stream and the archives within it are.
#[derive(Default)]
pub(crate) struct Standing {
    world: World,
    /// Objects that are open, whose gprims may be made before a world.
    objects: usize,
    /// Requests that were found misplaced.
    misplaced: Vec<Request>,
    /// What to warn of if a world begins: requests before it that may stand within one alone.
    early: Vec<String>,
}

impl Standing {
    /// Note a request; `place` is its file, line and column. What is wrong with where it stands is added to the warnings.
    /// Answers whether it is to be made: an option within the world is not.
    #[inline]
    pub(crate) fn note(&mut self, request: Request, place: impl Fn() -> String, warnings: &mut Vec<String>) -> bool {
        let row = request.row();
        if row.bracket != Bracket::Alone {
            self.bracket(request, warnings);
            return true;
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
            let message = format!("{}: `{}` stands {stands}, expected {expected}{refused}", place(), row.name);
            if self.world == World::Before { self.early.push(message) } else { warnings.push(message) }
        }
        is_made
    }

    /// Note a request that begins or ends a block. Whether blocks match is not asked here.
    fn bracket(&mut self, request: Request, warnings: &mut Vec<String>) {
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
    }
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
        read(Path::new("t.rib"), text.as_bytes(), &Files::default(), &mut heard, &mut |_, _| Ok(())).unwrap();
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
}
