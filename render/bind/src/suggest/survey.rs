//! What the rows of a frame are: the boxes of things, and the classes with their shapes. Every row is read once.

use super::lengths::Length;
use super::names::Names;
use crate::Up;
use frame::{Column, Frame};
use glam::{Mat3, Quat, Vec3};
use std::collections::HashMap;

/// A frame as a suggestion sees it.
pub(super) struct Survey<'a> {
    /// The boxes of the rows but planes and terrain, where their place is known.
    pub(super) things: Vec<Thing>,
    /// The boxes of the rows that are terrain.
    pub(super) terrain: Vec<Thing>,
    /// The classes and shapes, in the order of their first rows; empty if the frame is not one of a run of ours.
    pub(super) kinds: Vec<Kind<'a>>,
    /// Names of the classes, by their codes.
    pub(super) classes: &'a [String],
}

/// A row as the camera sees it.
#[derive(Clone)]
pub(super) struct Thing {
    pub(super) lo: Vec3,
    pub(super) hi: Vec3,
    /// Largest half length, m.
    pub(super) size: f32,
    /// Code of the class.
    pub(super) class: u32,
    /// Whether it is a body, or the first part of one.
    pub(super) is_body: bool,
    /// Whether it is thin and wide, as walls are.
    pub(super) is_plate: bool,
}

/// All rows of one class and shape.
#[derive(Clone)]
pub(super) struct Kind<'a> {
    pub(super) class: &'a str,
    pub(super) shape: &'a str,
    /// Whether some are planes that stand upright: walls, which would hide what is behind them.
    pub(super) has_walls: bool,
    /// Whether some are no walls.
    pub(super) has_others: bool,
    /// Lowest and highest of the planes that are level, m; none if there are no planes but walls, or some that are inclined.
    pub(super) levels: Option<[f32; 2]>,
    /// Rows in a frame, the most, and the largest radius or half length along x of these, m; none of planes.
    pub(super) count: usize,
    pub(super) largest: f32,
}

impl Thing {
    pub(super) fn center(&self) -> Vec3 {
        0.5 * (self.lo + self.hi)
    }
}

/// A column of lengths, m.
struct Metres<'a> {
    column: Option<&'a Column>,
    length: Length<'a>,
}

impl Metres<'_> {
    fn at(&self, row: usize) -> Option<f32> {
        self.column.and_then(|c| c.number(row)).map(|x| self.length.metres(x) as f32)
    }
}

/// The columns of a frame that are looked at.
struct Columns<'a> {
    place: [Metres<'a>; 3],
    radius: Option<Metres<'a>>,
    part: Option<&'a Column>,
    half: [Option<&'a Column>; 3],
    turn: [Option<&'a Column>; 4],
    up: Up,
}

fn number(column: Option<&Column>, row: usize) -> Option<f32> {
    column.and_then(|c| c.number(row)).map(|x| x as f32)
}

impl<'a> Columns<'a> {
    fn of(frame: &'a Frame, names: &Names<'a>, up: Up) -> Columns<'a> {
        let metres = |length: Length<'a>| Metres { column: frame.column(length.column), length };
        Columns {
            place: names.position.map(metres),
            radius: names.radius.map(metres),
            part: frame.column("part"),
            half: ["half_x", "half_y", "half_z"].map(|name| frame.column(name)),
            turn: ["quat_x", "quat_y", "quat_z", "quat_w"].map(|name| frame.column(name)),
            up,
        }
    }

    /// Whether the shape of a row is much thinner along one axis than along the two others.
    fn is_plate(&self, shape: &str, row: usize) -> bool {
        let mut half = self.half.map(|c| number(c, row).unwrap_or(0.0));
        half.sort_by(f32::total_cmp);
        matches!(shape, "box" | "cylinder") && half[0] <= 0.2 * half[1]
    }

    /// The half lengths of the box around a row.
    fn half(&self, shape: &str, row: usize) -> Vec3 {
        if shape.is_empty() || shape == "sphere" {
            return Vec3::splat(self.radius.as_ref().and_then(|r| r.at(row)).unwrap_or(0.0).max(0.0));
        }
        let mut half = Vec3::from_array(self.half.map(|c| number(c, row).unwrap_or(0.0)));
        if shape == "capsule" {
            half.z += half.x;
        }
        let turn = Mat3::from_quat(self.rotation(row));
        turn.x_axis.abs() * half.x + turn.y_axis.abs() * half.y + turn.z_axis.abs() * half.z
    }

    /// The rotation of a row, turned as the data is.
    fn rotation(&self, row: usize) -> Quat {
        let q = Quat::from_array(self.turn.map(|c| number(c, row).unwrap_or(0.0)));
        self.up.rotation() * if q.length() > 0.0 { q.normalize() } else { Quat::IDENTITY }
    }

    /// The place of a row, m, turned as the data is.
    fn place(&self, row: usize) -> Option<Vec3> {
        let [x, y, z] = &self.place;
        Some(self.up.turn_vector(Vec3::new(x.at(row)?, y.at(row)?, z.at(row)?)))
    }

    /// Vertical part of a plane's normal.
    fn normal_z(&self, row: usize) -> f32 {
        let q = self.rotation(row);
        1.0 - 2.0 * (q.x * q.x + q.y * q.y)
    }

    fn thing(&self, shape: &str, class: u32, row: usize) -> Option<Thing> {
        let place = self.place(row)?;
        let half = self.half(shape, row);
        let is_body = number(self.part, row).is_none_or(|part| part == 0.0);
        let (size, is_plate) = (half.max_element(), self.is_plate(shape, row));
        let thing = Thing { lo: place - half, hi: place + half, size, class, is_body, is_plate };
        (thing.lo.is_finite() && thing.hi.is_finite()).then_some(thing)
    }
}

impl<'a> Survey<'a> {
    pub(super) fn of(frame: &'a Frame, names: &Names<'a>, up: Up) -> Survey<'a> {
        let category = |name: &str| match frame.column(name) {
            Some(Column::Category { codes, names }) => (codes.as_slice(), names.as_slice()),
            _ => (&[][..], &[][..]),
        };
        let (shape_codes, shapes) = category("shape");
        let (class_codes, classes) = category("class");
        let columns = Columns::of(frame, names, up);
        let mut survey = Survey { things: vec![], terrain: vec![], kinds: vec![], classes };
        // Index into the kinds by class and shape: a table of all pairs would be far larger than the frame where each row has its own.
        let mut kind_of: HashMap<(u32, usize), usize> = HashMap::new();
        for row in 0..frame.rows() {
            let shape_code = shape_codes.get(row).map(|code| *code as usize);
            let class_code = class_codes.get(row).copied();
            let shape = shape_code.map_or("", |code| shapes[code].as_str());
            if let (Some(class), Some(shape)) = (class_code, shape_code) {
                let at = *kind_of.entry((class, shape)).or_insert_with(|| {
                    survey.kinds.push(Kind::new(&classes[class as usize], &shapes[shape]));
                    survey.kinds.len() - 1
                });
                survey.kinds[at].add(&columns, row);
            }
            if shape == "plane" {
                continue;
            }
            let all = if shape.starts_with("height_field") { &mut survey.terrain } else { &mut survey.things };
            all.extend(columns.thing(shape, class_code.unwrap_or(0), row));
        }
        survey
    }
}

impl<'a> Kind<'a> {
    fn new(class: &'a str, shape: &'a str) -> Kind<'a> {
        Kind { class, shape, has_walls: false, has_others: false, levels: None, count: 0, largest: 0.0 }
    }

    fn add(&mut self, columns: &Columns<'_>, row: usize) {
        if self.shape != "plane" {
            self.has_others = true;
            self.count += 1;
            self.largest = self.largest.max(number(columns.half[0], row).unwrap_or(0.0));
            return;
        }
        let normal_z = columns.normal_z(row);
        if normal_z < 0.5 {
            self.has_walls = true;
            return;
        }
        let height = columns.place(row).map(|place| place.z).filter(|_| normal_z > 0.999_999);
        let plane = Kind { has_others: true, levels: height.map(|z| [z, z]), ..*self };
        self.merge(&plane);
    }

    /// Add what is known of the same class and shape in another frame.
    pub(super) fn merge(&mut self, other: &Kind<'a>) {
        let count = self.count.max(other.count);
        self.add_all(other);
        self.count = count;
    }

    /// Add the rows of another class with the same shape in the same frame.
    pub(super) fn add_all(&mut self, other: &Kind<'a>) {
        self.has_walls |= other.has_walls;
        (self.count, self.largest) = (self.count + other.count, self.largest.max(other.largest));
        if other.has_others {
            self.levels = match (self.levels, other.levels) {
                (Some([lo, hi]), Some([a, b])) => Some([lo.min(a), hi.max(b)]),
                (_, levels) if !self.has_others => levels,
                _ => None,
            };
            self.has_others = true;
        }
    }

    /// Whether all rows but walls are planes at this height.
    pub(super) fn is_level_at(&self, height: f32) -> bool {
        self.levels.is_some_and(|levels| levels.iter().all(|level| (level - height).abs() < 1e-3))
    }
}
