//! Kernels: a shader with the shaders of the lights that shine on it, as one text.

use super::super::bound::{Answer, BoundShader};
use super::super::scene::Scene;
use super::module::{Asked, Host, LightShader, Module, Query, Refused, Slot};
use super::registers::type_of;
use super::specialise::specialised;
use super::texts::ask;
use super::writer::Writer;
use crate::ir::builtins::{How, SceneCall};
use crate::ir::walk::writes_besides;
use crate::ir::{Ask, Global, Lookup, Op, Operand, Parameter, Program, Reg, ShaderKind, visit};
use std::collections::{BTreeSet, HashSet};
use std::sync::Arc;

/// What a value that a shader gives is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// A global variable.
    Global(Global),
    /// The output parameter of a slot.
    Parameter(usize),
}

/// A value that a shader gives at every point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Output {
    /// What it is.
    pub target: Target,
    /// Count of its numbers.
    pub width: usize,
    /// Count of the numbers that stand before it among a point's results.
    pub offset: usize,
}

/// A shader in a kernel.
#[derive(Clone, Debug)]
pub struct Shader {
    /// The bound shader that it was written for.
    pub(super) bound: Arc<BoundShader>,
    /// What it reads of the host, and the byte of its source where it does so first.
    pub(super) slots: Vec<(Slot, u32)>,
    pub(super) outputs: Vec<Output>,
}

/// A kernel for a shader and lights.
#[derive(Clone, Debug)]
pub struct Kernel {
    /// The WGSL text.
    pub text: String,
    /// Invocations of a workgroup.
    pub group: u32,
    /// Whether workgroups shade whole grids, of at most `group` points.
    pub grid: bool,
    /// The shader, then those of lights.
    pub(super) shaders: Vec<Shader>,
    /// Of each light: index of its shader; none if the shader asks for no lights.
    pub(super) of_light: Vec<usize>,
    /// Categories of lights that are asked for, by their bits.
    pub(super) categories: Vec<String>,
    /// Queries whose answers are strings, with the answers that the kernel was written for.
    pub(super) asked: Vec<Asked>,
    /// Queries that the host's functions answer.
    queries: BTreeSet<Query>,
}

/// Points of a workgroup that shades points each on its own, as `parts/flat.wgsl` has it.
const FLAT_GROUP: u32 = 64;

impl Kernel {
    /// Write the kernel of a shader for lights.
    ///
    /// # Errors
    /// What the shader or a light's does that no kernel can do.
    pub fn new(shader: &Arc<BoundShader>, lights: &[Arc<BoundShader>], host: Host<'_>) -> Result<Kernel, Refused> {
        if shader.program.kind == ShaderKind::Light {
            return Err(refused(shader, "is a light's, and is run for a surface"));
        }
        let own = specialised(shader, host.scene);
        let (of_light, kinds) = kinds(if asks_lights(&own) { lights } else { &[] });
        let others = kinds.iter().map(|b| specialised(b, host.scene));
        let programs: Vec<Program> = [own].into_iter().chain(others).collect();
        let bound: Vec<&Arc<BoundShader>> = [shader].into_iter().chain(kinds).collect();
        let grid = programs.iter().any(|p| p.reads_neighbours);
        let mut module = Module {
            host,
            grid,
            lights: vec![],
            categories: vec![],
            asked: vec![],
            queries: BTreeSet::new(),
            functions: String::new(),
        };
        let (mut text, mut shaders) = (String::new(), vec![]);
        // Lights first: what calls them depends on what they do.
        for (k, program) in programs.iter().enumerate().skip(1) {
            let light = function(&mut module, program, bound[k], k, &mut text)?;
            let (grid, is_ambient) = (program.reads_neighbours, program.is_ambient);
            module.lights.push(LightShader { grid, is_ambient, parameters: parameters(program) });
            shaders.push(light);
        }
        shaders.insert(0, function(&mut module, &programs[0], bound[0], 0, &mut text)?);
        if !of_light.is_empty() || asks_lights(&programs[0]) {
            text += &run_light(&module);
        }
        let group = if grid { host.group } else { FLAT_GROUP };
        let text = assemble(&module, shader, &text, group);
        let Module { categories, asked, queries, .. } = module;
        Ok(Kernel { text, group, grid, shaders, of_light, categories, asked, queries })
    }

    /// Count of results of a point.
    pub fn n_results(&self) -> usize {
        self.shaders[0].outputs.iter().map(|o| o.width).sum()
    }

    /// The values that the shader gives at every point.
    pub fn outputs(&self) -> &[Output] {
        &self.shaders[0].outputs
    }

    /// What it gives of a name: an output parameter, else a global that it changes.
    pub fn output_of(&self, name: &str, global: Option<Global>) -> Option<Output> {
        let params = &self.shaders[0].bound.program.params;
        let find = |is_it: &dyn Fn(Target) -> bool| self.outputs().iter().find(|o| is_it(o.target)).copied();
        let parameter = find(&|target| matches!(target, Target::Parameter(k) if params[k].name == name));
        parameter.or_else(|| find(&|target| global.is_some_and(|g| target == Target::Global(g))))
    }

    /// Whether it asks the host's functions a query.
    pub fn asks(&self, query: Query) -> bool {
        self.queries.contains(&query)
    }

    /// Whether a scene answers with the strings that it was written for.
    pub fn is_answered_by(&self, scene: &dyn Scene) -> bool {
        self.other_answer(scene).is_none()
    }

    /// The names by which a scene is asked for a string that is another than it was written for.
    pub(super) fn other_answer(&self, scene: &dyn Scene) -> Option<&[String]> {
        let is_other = |(what, names, answer): &&Asked| {
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            ask(*what, &names, scene) != *answer
        };
        self.asked.iter().find(is_other).map(|(_, names, _)| names.as_slice())
    }

    /// Whether its shader asks for numbers by name of something.
    pub fn asks_by_name(&self, of: Ask) -> bool {
        self.shaders[0].slots.iter().any(|(slot, _)| matches!(slot, Slot::Answer { what, .. } if *what == of))
    }

    /// The maps that shaders of the kernel look up: how, the name, and whether a light's shader does. One without a name is none.
    pub fn maps(&self) -> impl Iterator<Item = (Lookup, &str, bool)> {
        let slots =
            self.shaders.iter().enumerate().flat_map(|(k, shader)| shader.slots.iter().map(move |(s, _)| (k, s)));
        slots.filter_map(|(k, slot)| match slot {
            Slot::Map { how, name } if !name.is_empty() => Some((*how, name.as_str(), k > 0)),
            _ => None,
        })
    }

    /// The name of a light whose shader reads what differs from primitive to primitive: the spaces of these, or an answer other than
    /// that of an option. A [`super::Batch`] then serves one primitive alone.
    pub fn light_of_primitive(&self) -> Option<&str> {
        let own = |light: &Shader, space: &String| matches!(light.bound.space_of(space), "object" | "shape" | "shader");
        let differs = |light: &Shader, slot: &Slot| match slot {
            Slot::Matrix { from, to } | Slot::NormalMatrix { from, to } => own(light, from) || own(light, to),
            Slot::Map { .. } => false,
            Slot::Answer { what, .. } => !matches!(what, Ask::Option | Ask::TextureInfo | Ask::RendererInfo),
        };
        let light = self.shaders[1..].iter().find(|light| light.slots.iter().any(|(slot, _)| differs(light, slot)))?;
        Some(&light.bound.program.name)
    }

    /// Whether the kernel is that of a shader, too: one of the same program and strings.
    pub fn is_of(&self, shader: &BoundShader) -> bool {
        alike(&self.shaders[0].bound, shader)
    }
}

fn refused(shader: &BoundShader, reason: &str) -> Refused {
    Refused { shader: shader.program.name.clone(), reason: reason.into() }
}

/// Whether two bound shaders differ in numbers alone.
fn alike(a: &BoundShader, b: &BoundShader) -> bool {
    let same = |slot: usize| match (a.value(slot), b.value(slot)) {
        (Some(Answer::Numbers(_)), Some(Answer::Numbers(_))) => true,
        (a, b) => a == b,
    };
    Arc::ptr_eq(&a.program, &b.program) && (0..a.program.params.len()).all(same)
}

/// Whether a shader asks what lights give.
fn asks_lights(program: &Program) -> bool {
    let mut found = false;
    visit(&program.body, &mut |op| {
        found |= match op {
            Op::Illuminance { .. } => true,
            Op::Call(f, ..) => matches!(f.row().how, How::Scene(SceneCall::Ambient)),
            _ => false,
        }
    });
    found
}

/// The shaders of lights, those that differ in numbers alone once: the index of each light's in a kernel, and the shaders.
fn kinds(lights: &[Arc<BoundShader>]) -> (Vec<usize>, Vec<&Arc<BoundShader>>) {
    let mut kinds: Vec<&Arc<BoundShader>> = vec![];
    let mut of_light = vec![];
    for light in lights {
        let k = kinds.iter().position(|kind| alike(kind, light)).unwrap_or_else(|| {
            kinds.push(light);
            kinds.len() - 1
        });
        of_light.push(k + 1);
    }
    (of_light, kinds)
}

/// What is asked of a light: single parameters that are numbers.
fn parameters(program: &Program) -> Vec<(String, usize, usize, bool)> {
    let number = |(slot, p): (usize, &Parameter)| match p.reg {
        Operand::Number(r) => Some((p.name.clone(), slot, r.width(), p.output && p.array.is_none())),
        Operand::Text(_) => None,
    };
    program.params.iter().enumerate().filter_map(number).collect()
}

/// Write the function of a shader.
fn function(
    module: &mut Module<'_>,
    program: &Program,
    bound: &Arc<BoundShader>,
    index: usize,
    text: &mut String,
) -> Result<Shader, Refused> {
    let is_light = index > 0;
    let mut w = Writer::new(module, program, bound, index);
    w.grid = if is_light { program.reads_neighbours } else { w.module.grid };
    // A light runs for the points that ask for it.
    w.masks = is_light as usize;
    read_globals(&mut w, is_light);
    read_parameters(&mut w)?;
    w.block(&program.body)?;
    let outputs = if is_light { vec![] } else { outputs(program) };
    if is_light {
        give_light(&mut w);
    } else {
        write_outputs(&mut w, &outputs);
    }
    let on = if is_light && !w.grid { "" } else { ", on_at_start: bool" };
    let begin = if on.is_empty() { "" } else { "    var on = on_at_start;\n" };
    let (takes, gives) = match is_light {
        true => (", ps: vec3<f32>, ns: vec3<f32>, receiver: vec3<f32>, receiver_cosine: f32", " -> Lit"),
        false => ("", ""),
    };
    let lit = if is_light { "    var lit_on = false;\n" } else { "" };
    let turn = if w.counts_turns { "    var turn = 0u;\n" } else { "" };
    let kind = program.kind.name();
    *text += &format!("\n// The {kind} shader `{}`.\n", program.name);
    *text += &format!("fn shader_{index}(base: u32{on}{takes}){gives} {{\n{begin}{lit}{turn}");
    *text += &(w.registers.declarations() + &w.variables + &w.text + "}\n");
    Ok(Shader { bound: bound.clone(), slots: w.slots, outputs })
}

fn read_globals(w: &mut Writer, is_light: bool) {
    for (global, reg) in &w.program.globals {
        let (name, width) = (w.registers.name(*reg), reg.width());
        w.written.insert(reg.index());
        let value = match global {
            Global::Ps if is_light => "ps".into(),
            Global::Ns if is_light => "ns".into(),
            _ => format!("sl_read{width}(base + {}u, 0u)", global.slot()),
        };
        w.line(format!("{name} = {value};"));
    }
}

/// Parameters that are numbers: what was given, else the default.
fn read_parameters(w: &mut Writer) -> Result<(), Refused> {
    for (k, param) in w.program.params.iter().enumerate() {
        let Operand::Number(first) = param.reg else { continue };
        let slot = format!("base + {}u", Global::COUNT + k);
        let registers: Vec<Reg> = first.array(param.array.unwrap_or(1)).collect();
        w.written.extend(registers.iter().map(|r| r.index()));
        let has_default = w.shader.value(k).is_none();
        if has_default {
            if param.default.iter().any(|op| w.is_together(op)) {
                return w.refuse(format!("computes the default of `{}` from neighbouring points", param.name));
            }
            w.open(format!("if slots[{slot}].y == 0u"));
            w.block(&param.default)?;
            w.between("else");
        }
        for (k, r) in registers.into_iter().enumerate() {
            let line = format!("{} = sl_read{}({slot}, {k}u);", w.registers.name(r), r.width());
            w.line(line);
        }
        if has_default {
            w.close();
        }
    }
    Ok(())
}

/// What a shader gives: globals that it changes, and output parameters.
fn outputs(program: &Program) -> Vec<Output> {
    let mut changed = BTreeSet::new();
    visit(&program.body, &mut |op| {
        if let Op::Assign(r, _) | Op::Ask { out: Operand::Number(r), .. } = op {
            changed.insert(r.index());
        }
        if !matches!(op, Op::Illuminance { .. }) {
            writes_besides(op, &mut |r| _ = changed.insert(r.index()));
        }
    });
    let globals = program.globals.iter().filter(|(_, r)| changed.contains(&r.index()));
    let globals = globals.map(|(g, r)| (Target::Global(*g), r.width()));
    let params = program.params.iter().enumerate().filter(|(_, p)| p.output && p.array.is_none());
    let params = params.filter_map(|(k, p)| match p.reg {
        Operand::Number(r) => Some((Target::Parameter(k), r.width())),
        Operand::Text(_) => None,
    });
    let mut offset = 0;
    let mut place = |(target, width)| {
        offset += width;
        Output { target, width, offset: offset - width }
    };
    globals.chain(params).map(&mut place).collect()
}

fn write_outputs(w: &mut Writer, outputs: &[Output]) {
    if w.grid {
        w.open("if on");
    }
    for output in outputs {
        let reg = match output.target {
            Target::Global(g) => w.program.global(g),
            Target::Parameter(k) => match w.program.params[k].reg {
                Operand::Number(r) => Some(r),
                Operand::Text(_) => None,
            },
        };
        for (c, reg) in (0..output.width).zip(std::iter::repeat(reg.expect("outputs are numbers"))) {
            let line = format!("sl_write({}u, {});", output.offset + c, w.registers.component(reg, c));
            w.line(line);
        }
    }
    if w.grid {
        w.close();
    }
}

/// The end of a light's function.
fn give_light(w: &mut Writer) {
    for (k, param) in w.program.params.iter().enumerate().filter(|(_, p)| p.output && p.array.is_none()) {
        let Operand::Number(r) = param.reg else { continue };
        let given = format!("given_{}_{}", w.index, Global::COUNT + k);
        w.module.functions += &format!("\nvar<private> {given}: {};\n", type_of(r.width()));
        let line = format!("{given} = {};", w.registers.name(r));
        w.line(line);
    }
    let of = |g| w.program.global(g).map_or("vec3<f32>()".into(), |r| w.registers.name(r));
    let line = format!("return Lit(lit_on, {}, {});", of(Global::L), of(Global::Cl));
    w.line(line);
}

/// The functions that run the shader of a light, of those that loops meet and of those that are ambient, and the sum of the latter.
fn run_light(module: &Module<'_>) -> String {
    let number = if module.has_grid_light() { "sl_uniform(i)" } else { "i" };
    let [run_light, run_ambient] = [("run_light", false), ("run_ambient", true)].map(|kind| run_lights(module, kind));
    format!(
        "{run_light}{run_ambient}
// The sum of the ambient lights.
fn sl_ambient() -> vec3<f32> {{
    var sum: vec3<f32>;
    var i = 0u;
    loop {{
        let k = {number};
        if k >= work.n_lights {{ break; }}
        i += 1u;
        let light = lights[work.first_light + k];
        if light.w == 0u {{ continue; }}
        sum += run_ambient(light, true, sl_read3(work.slots, 0u), sl_facing(), vec3<f32>(), -2.0).cl;
    }}
    return sum;
}}
"
    )
}

/// The function that runs the shader of a light, of one of two kinds: a light is written once for each place that runs it.
fn run_lights(module: &Module<'_>, (name, is_ambient): (&str, bool)) -> String {
    let together = module.has_grid_light();
    let mut cases = String::new();
    for (k, light) in module.lights.iter().enumerate().filter(|(_, light)| light.is_ambient == is_ambient) {
        let (k, given) = (k + 1, "ps, ns, receiver, receiver_cosine");
        cases += &match (together, light.grid) {
            (_, true) => format!("        case {k}u: {{ lit = shader_{k}(light.y, on, {given}); }}\n"),
            (true, false) => {
                format!(
                    "        case {k}u: {{\n            if on {{ lit = shader_{k}(light.y, {given}); }}\n        }}\n"
                )
            }
            (false, false) => format!("        case {k}u: {{ lit = shader_{k}(light.y, {given}); }}\n"),
        };
    }
    let kind = if together { "sl_uniform(light.x)" } else { "light.x" };
    let what = if is_ambient { "an ambient light" } else { "a light" };
    format!(
        "
// What {what} gives to a point.
fn {name}(
    light: vec4<u32>,
    on: bool,
    ps: vec3<f32>,
    ns: vec3<f32>,
    receiver: vec3<f32>,
    receiver_cosine: f32,
) -> Lit {{
    var lit: Lit;
    switch {kind} {{
{cases}        default: {{}}
    }}
    return lit;
}}
"
    )
}

/// The parts of which a kernel takes the functions that it needs.
const PARTS: [&str; 5] = [
    include_str!("parts/number.wgsl"),
    include_str!("parts/matrix.wgsl"),
    include_str!("parts/noise.wgsl"),
    include_str!("parts/color.wgsl"),
    include_str!("parts/rays.wgsl"),
];

/// The whole text.
fn assemble(module: &Module<'_>, shader: &BoundShader, functions: &str, group: u32) -> String {
    let (kind, name) = (shader.program.kind.name(), &shader.program.name);
    let mut text = format!("// The kernel of the {kind} shader `{name}`.\n\n");
    for (constant, global) in [("GLOBAL_N", Global::N), ("GLOBAL_I", Global::I)] {
        text += &format!("const {constant}: u32 = {}u;\n", global.slot());
    }
    if module.grid {
        text += &format!("const GROUP: u32 = {group}u;\n");
    }
    text += &format!("\n{}", include_str!("parts/kernel.wgsl"));
    text += if module.grid { include_str!("parts/grid.wgsl") } else { include_str!("parts/flat.wgsl") };
    let mut offered = module.host.functions.iter().filter(|(query, _)| module.queries.contains(query)).peekable();
    if offered.peek().is_some() && !module.host.declarations.is_empty() {
        text += &format!("\n{}\n", module.host.declarations);
    }
    offered.for_each(|(_, function)| text += &format!("\n{function}\n"));
    text += &module.functions;
    text += functions;
    with_parts(text)
}

/// A text with the functions of [`PARTS`] that it calls, and those that these call.
fn with_parts(mut text: String) -> String {
    let mut items: Vec<(&str, &str)> =
        PARTS.iter().flat_map(|part| part.split("\n\n")).filter_map(|item| Some((defined(item)?, item))).collect();
    let mut mentioned: HashSet<String> = words(&text).map(String::from).collect();
    loop {
        let before = items.len();
        items.retain(|(name, item)| {
            let wanted = mentioned.contains(*name);
            if wanted {
                text += &format!("\n{}\n", item.trim_end());
                mentioned.extend(words(item).map(String::from));
            }
            !wanted
        });
        if items.len() == before {
            return text;
        }
    }
}

/// The name of the function or constant that an item of a part defines.
fn defined(item: &str) -> Option<&str> {
    let line = item.lines().find_map(|l| l.strip_prefix("fn ").or(l.strip_prefix("const ")))?;
    line.split(['(', ':']).next()
}

/// The words of a text.
fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).filter(|word| !word.is_empty())
}
