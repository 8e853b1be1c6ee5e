//! The layout of the viewer: the bodies as the metadata's camera sees them, and a plot for each unit of the probes.

use crate::curves::Series;
use crate::fault::Failure;
use bind::binding::{Camera, Projection};
use bind::{Binding, emit};
use frame::Frame;
use rerun::blueprint::components::{
    ColumnShare, ContainerKind, IncludedContent, PanelState, QueryExpression, RootContainer, ViewClass,
};
use rerun::components::{Name, Position3D, Vector3D};
use rerun::external::re_log_types::{BlueprintActivationCommand, LogMsg};
use rerun::external::re_sdk_types::blueprint::archetypes::{
    ContainerBlueprint, EyeControls3D, PanelBlueprint, TimePanelBlueprint, ViewBlueprint, ViewContents,
    ViewportBlueprint,
};
use rerun::external::uuid::Uuid;
use rerun::{RecordingStream, RecordingStreamBuilder};

/// Plots at most.
const PLOTS: usize = 6;

/// Send the layout for a binding whose first frame is `first`, with the curves of `series`, along a time line.
pub fn send(
    binding: &Binding,
    first: Option<&Frame>,
    series: &[Series],
    timeline: &str,
    stream: &RecordingStream,
) -> Result<(), Failure> {
    let Some(info) = stream.store_info() else { return Ok(()) };
    let (layout, messages) = RecordingStreamBuilder::new(info.application_id().clone()).blueprint().memory()?;
    layout.set_time_sequence("blueprint", 0);
    let scene = view(&layout, "3D", "bodies", ["/bodies/**".to_string(), "/contacts/**".into()])?;
    if let Some(eye) = eye(binding, first) {
        layout.log(format!("{scene}/EyeControls3D"), &eye)?;
    }
    let mut parts = vec![scene];
    let mut plots = vec![];
    for (name, entities) in series.iter().flat_map(Series::groups).take(PLOTS) {
        plots.push(view(&layout, "TimeSeries", &name, entities.iter().map(|entity| entity.to_string()))?);
    }
    if !plots.is_empty() {
        parts.push(container(&layout, ContainerKind::Vertical, &plots, &[])?.0);
    }
    let (_, root) = container(&layout, ContainerKind::Horizontal, &parts, &[2.0, 1.0])?;
    layout.log("viewport", &ViewportBlueprint::new().with_root_container(RootContainer(root.into())))?;
    for panel in ["blueprint_panel", "selection_panel"] {
        layout.log(panel, &PanelBlueprint::new().with_state(PanelState::Collapsed))?;
    }
    layout.log("time_panel", &TimePanelBlueprint::new().with_timeline(timeline))?;
    let messages = messages.take();
    let store = messages.iter().find_map(|message| match message {
        LogMsg::SetStoreInfo(info) => Some(info.info.store_id.clone()),
        _ => None,
    });
    if let Some(blueprint_id) = store {
        let activation = BlueprintActivationCommand { blueprint_id, make_active: true, make_default: true };
        stream.send_blueprint(messages, activation);
    }
    Ok(())
}

/// A view of some entities; its path.
fn view(
    layout: &RecordingStream,
    class: &str,
    name: &str,
    contents: impl IntoIterator<Item = String>,
) -> Result<String, Failure> {
    let path = format!("view/{}", Uuid::new_v4());
    let queries = contents.into_iter().map(|query| QueryExpression(format!("+ {query}").into()));
    layout.log(format!("{path}/ViewContents"), &ViewContents::new(queries))?;
    let own = ViewBlueprint::new(ViewClass(class.into())).with_display_name(Name(name.into())).with_space_origin("/");
    layout.log(path.as_str(), &own)?;
    Ok(path)
}

/// A container of views and containers; its path and id.
fn container(
    layout: &RecordingStream,
    kind: ContainerKind,
    parts: &[String],
    shares: &[f32],
) -> Result<(String, Uuid), Failure> {
    let id = Uuid::new_v4();
    let path = format!("container/{id}");
    let contents = parts.iter().map(|part| IncludedContent(part.as_str().into()));
    let mut own = ContainerBlueprint::new(kind).with_contents(contents);
    if shares.len() == parts.len() {
        own = own.with_col_shares(shares.iter().map(|share| ColumnShare((*share).into())));
    }
    layout.log(path.as_str(), &own)?;
    Ok((path, id))
}

/// The eye of the metadata's camera in the first frame; none if a file has it, or if it cannot be placed.
fn eye(binding: &Binding, first: Option<&Frame>) -> Option<EyeControls3D> {
    let Some(Camera::Placed(camera)) = &binding.camera else { return None };
    let stand = emit::stand(binding, first?).ok()??;
    // The viewer has an angle of view of its own, 55 degrees: from where as much is seen.
    let slope = |degrees: f32| (0.5 * degrees).to_radians().tan();
    let way = [0, 1, 2].map(|k| stand.eye[k] - stand.at[k]);
    let length = way.iter().map(|x| x * x).sum::<f32>().sqrt();
    let distance = match camera.projection {
        Projection::Parallel(height) => 0.5 * height / slope(55.0),
        Projection::Perspective(fov) => length * slope(fov) / slope(55.0),
    };
    let eye = [0, 1, 2].map(|k| stand.at[k] + way[k] * distance / length);
    let controls = EyeControls3D::new()
        .with_position(Position3D::from(eye))
        .with_look_target(Position3D::from(stand.at))
        .with_eye_up(Vector3D::from(camera.up));
    Some(controls)
}
