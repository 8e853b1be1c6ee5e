//! Names of bodies, found by the name and by the body.

use std::collections::BTreeMap;
use std::ops::Index;

/// The named bodies of a model: each name with the id of its body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodyNames {
    ids: BTreeMap<String, u32>,
    /// The first name of each body, in the order of the names.
    names: BTreeMap<u32, String>,
}

impl BodyNames {
    /// Name a body.
    pub fn insert(&mut self, name: String, body: u32) {
        let first = self.names.entry(body).or_insert_with(|| name.clone());
        if name < *first {
            first.clone_from(&name);
        }
        self.ids.insert(name, body);
    }

    /// The id of the body with a name.
    pub fn get(&self, name: &str) -> Option<u32> {
        self.ids.get(name).copied()
    }

    /// The name of a body.
    pub fn of(&self, body: u32) -> Option<&str> {
        self.names.get(&body).map(String::as_str)
    }

    /// All names with the ids of their bodies, in the order of the names.
    pub fn iter(&self) -> impl Iterator<Item = (&str, u32)> {
        self.ids.iter().map(|(name, body)| (name.as_str(), *body))
    }
}

impl Index<&str> for BodyNames {
    type Output = u32;

    /// The id of the body with a name; panics if there is none.
    fn index(&self, name: &str) -> &u32 {
        &self.ids[name]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_are_found_by_name_and_names_by_body() {
        let mut names = BodyNames::default();
        for (name, body) in [("wheel", 3), ("axle", 1), ("hub", 3)] {
            names.insert(name.into(), body);
        }
        assert_eq!((names.get("wheel"), names.get("hub"), names.get("tyre")), (Some(3), Some(3), None));
        assert_eq!((names.of(1), names.of(3), names.of(0)), (Some("axle"), Some("hub"), None));
        assert_eq!(names.iter().collect::<Vec<_>>(), [("axle", 1), ("hub", 3), ("wheel", 3)]);
        assert_eq!(names["wheel"], 3);
    }
}
