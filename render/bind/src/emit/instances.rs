//! The rows of an object → columns of instances.

use super::group::{Group, select};
use super::missing::Missing;
use super::rows::{Rows, range_of};
use super::{arrows, trails};
use crate::binding::{Archive, Binding, Color, Object, Shape};
use crate::moment::Moment;
use frame::{Fault, Frame};
use glam::{Quat, Vec3};
use ri::{InstanceShape, Instances};

/// An object's instances, made before the scene is read, so that a fault in the data stops nothing half way.
pub struct Prepared<'a> {
    /// The object.
    pub object: &'a Object,
    /// One, but one for each file that rows are drawn from.
    pub groups: Vec<Group<'a>>,
    /// The trails of bodies.
    pub trails: trails::Curves,
    /// What the rows lack.
    pub missing: Missing,
}

/// The range of the values that the `i`th object is coloured by; none if it is of one colour, or has no values.
pub(super) fn color_range(
    binding: &Binding,
    i: usize,
    object: &Object,
    moment: &Moment,
) -> Result<Option<[f64; 2]>, Fault> {
    let (Color::By { value, .. }, Some(frame)) = (&object.color, frame_of(object, moment)) else { return Ok(None) };
    let (lo, hi) = range_of(&Rows::of(binding, i, object, frame)?.values("color", &value.expr)?);
    Ok((lo <= hi).then_some([lo, hi]))
}

/// The range of the lengths of the vectors of the `i`th object; none if it has no arrows.
pub(super) fn arrow_range(
    binding: &Binding,
    i: usize,
    object: &Object,
    moment: &Moment,
) -> Result<Option<[f64; 2]>, Fault> {
    let Some(frame) = frame_of(object, moment) else { return Ok(None) };
    let (lo, hi) = range_of(&arrows::lengths(&Rows::of(binding, i, object, frame)?, object)?);
    Ok((lo <= hi).then_some([lo, hi]))
}

/// The table that has the rows of an object; none if it has no rows.
fn frame_of<'a>(object: &Object, moment: &'a Moment) -> Option<&'a Frame> {
    let frame = if object.of_contacts { moment.contacts.as_ref() } else { Some(moment.frame) };
    frame.filter(|frame| frame.rows() > 0)
}

/// Evaluate the rows of the `i`th object into columns of instances.
pub(super) fn prepare<'a>(
    binding: &Binding,
    i: usize,
    object: &'a Object,
    moment: &Moment,
) -> Result<Prepared<'a>, Fault> {
    let trails = trails::Curves::default();
    let Some(frame) = frame_of(object, moment) else {
        let missing = Missing { absent: vec![object.name.clone()], ..Missing::default() };
        return Ok(Prepared { object, groups: vec![], trails, missing });
    };
    let mut rows = Rows::of(binding, i, object, frame)?;
    let sphere = matches!(object.shape, Shape::Sphere(_) | Shape::Ellipsoid(_));
    let handle = (!sphere).then(|| format!("scree:{}", object.name));
    let mut instances = rows.instances(object, handle.as_ref())?;
    let absent = if rows.rows.is_empty() { vec![object.name.clone()] } else { vec![] };
    let mut missing = Missing { undrawn: rows.drop_missing(), absent, ..Missing::default() };
    if missing.undrawn.rows > 0 {
        instances = rows.instances(object, handle.as_ref())?;
    }
    if let Shape::Trail(trail) = &object.shape {
        let trails = trails::prepare(binding, i, object, *trail, moment)?;
        return Ok(Prepared { object, groups: vec![], trails, missing });
    }
    if let Color::By { value, map, range } = &object.color {
        let (colors, lack) = rows.colors(value, *map, *range)?;
        instances.params.push(colors);
        missing.uncolored = lack;
    }
    if object.surface.is_some() || object.displacement.is_some() {
        instances.params.push(rows.ids());
    }
    let group = |handle: Option<String>, archive, instances| Group {
        handle,
        archive,
        is_head: false,
        instances: vec![instances],
    };
    let groups = match &object.shape {
        Shape::Archive(Archive::File(file), _) => vec![group(handle, Some(file.as_str()), instances)],
        Shape::Archive(Archive::ByColumn { column, files }, _) => {
            let of_rows = rows.files(column, files)?;
            let group = |(k, (_, file)): (usize, &'a (String, String))| {
                let chosen: Vec<usize> = (0..of_rows.len()).filter(|i| of_rows[*i] == k).collect();
                let handle = format!("scree:{}:{k}", object.name);
                let shape = InstanceShape::Object(handle.clone());
                group(Some(handle), Some(file.as_str()), Instances { shape, ..select(&instances, &chosen) })
            };
            let groups = files.iter().enumerate().map(group);
            groups.filter(|group| !group.instances[0].is_empty()).collect()
        }
        Shape::Capsule(_) => {
            let ends = capsule_ends(&instances);
            let instances = std::iter::once(instances).chain(ends).collect();
            vec![Group { handle, archive: None, is_head: false, instances }]
        }
        Shape::Arrow(arrow) => arrows::groups((binding, i, object), arrow, &rows, &instances)?,
        _ => vec![group(handle, None, instances)],
    };
    Ok(Prepared { object, groups, trails, missing })
}

/// The spheres at a capsule's ends.
fn capsule_ends(middle: &Instances) -> Vec<Instances> {
    let along = |places: &[[f32; 3]], i: usize, side: f32| {
        let q = middle.orientation.get(i).map_or(Quat::IDENTITY, |q| Quat::from_array(*q));
        let [_, _, half] = middle.scale[i];
        (Vec3::from(places[i]) + q * Vec3::new(0.0, 0.0, side * half)).to_array()
    };
    let all = |places: &[[f32; 3]], side: f32| (0..middle.len()).map(|i| along(places, i, side)).collect::<Vec<_>>();
    let sphere = |side: f32| Instances {
        shape: InstanceShape::Sphere,
        position: all(&middle.position, side),
        moved: middle.moved.as_ref().map(|(times, to)| (*times, all(to, side))),
        scale: middle.scale.iter().map(|[r, _, _]| [*r; 3]).collect(),
        // They have the object space of the middle, so that patterns go on across the seam.
        offset: middle.scale.iter().map(|[_, _, half]| [0.0, 0.0, side * half]).collect(),
        ..middle.clone()
    };
    vec![sphere(-1.0), sphere(1.0)]
}
