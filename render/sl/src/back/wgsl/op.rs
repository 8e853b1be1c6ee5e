//! Operations as statements.

use super::super::bound::Answer;
use super::super::scene::asked_in_vain;
use super::module::{Refused, Slot};
use super::registers::{literal, type_of};
use super::texts;
use super::value::{binary, is_for_triples, unary};
use super::writer::{Done, Writer};
use crate::ir::{Ask, Binary, FloatReg, Op, Operand, Reg, TextReg, Transform, TripleReg, Unary};
use crate::shadeop::color::SPACES;
use crate::shadeop::number::{binary_value, unary_value};

impl Writer<'_, '_> {
    /// Write an operation. Long, because it has an arm for each.
    pub fn op(&mut self, op: &Op) -> Done {
        match op {
            Op::Const(dst, x) => self.constant(*dst, *x),
            Op::TextConst(..) | Op::TextCopy(..) | Op::TextLoad(..) | Op::TextStore(..) | Op::Format(..) => Ok(()),
            Op::TextEqual(..) | Op::Match(..) => match self.texts.truth(op) {
                Some((dst, truth)) => self.set(dst.into(), literal(truth as u8 as f32)),
                None => self.refuse("compares a string that is only known while it runs"),
            },
            Op::Unary(f, dst, a) => self.unary(*f, *dst, *a),
            Op::Binary(f, dst, a, b) => self.binary(*f, *dst, *a, *b),
            Op::Select(dst, c, a, b) => self.select(*dst, *c, *a, *b),
            Op::Pack(dst, parts) => {
                let parts: Vec<String> = parts.iter().map(|r| self.registers.value(*r)).collect();
                self.set(*dst, format!("{}({})", type_of(dst.width()), parts.join(", ")))
            }
            Op::Component(dst, a, c) => self.set((*dst).into(), self.registers.component((*a).into(), *c as usize)),
            Op::Assign(dst, a) => {
                let value = self.registers.spread(*a, dst.width());
                self.assign(*dst, &value);
                Ok(())
            }
            Op::Within(index, len, place) => self.within(*index, *len, *place),
            Op::Load(dst, first, len, index, place) => self.load(*dst, *first, *len, *index, *place),
            Op::Store(first, len, index, value, place) => self.store(*first, *len, *index, *value, *place),
            Op::ColorSpace(dst, a, from, to, _) => self.color_space(*dst, *a, *from, *to),
            Op::Spline(dst, basis, args) => self.spline(*dst, *basis, args),
            Op::Print(_) => self.refuse("prints"),
            Op::Ask { dst, what, names, out, len, place } => {
                self.byte = *place;
                self.ask(*dst, *what, names, *out, *len)
            }
            Op::Map { place, .. } => {
                self.byte = *place;
                self.map(op)
            }
            Op::Call(f, dst, args) => self.call(*f, *dst, args),
            Op::Transform(how, dst, a, from, to, place) => {
                self.byte = *place;
                self.transform(*how, *dst, *a, *from, *to)
            }
            Op::If(..) | Op::Loop(..) | Op::Inline(_) => self.control(op),
            Op::Break(levels) => self.leave(*levels as usize, true),
            Op::Continue(levels) => self.leave(*levels as usize, false),
            Op::Return => self.leave_function(),
            Op::Gather { .. } => self.gather(op),
            Op::Illuminance { .. } => self.illuminance(op),
            Op::Solar { axis, l, body, .. } => self.solar(*axis, *l, body),
            Op::Illuminate { .. } => self.illuminate(op),
        }
    }

    /// Set a value that is no variable.
    pub fn set(&mut self, dst: Reg, value: String) -> Done {
        let dst = self.registers.name(dst);
        self.line(format!("{dst} = {value};"));
        Ok(())
    }

    fn constant(&mut self, dst: Reg, x: f32) -> Done {
        // Readers have the number itself.
        if self.registers.constant(dst).is_some() {
            return Ok(());
        }
        let value = match dst.width() {
            1 => literal(x),
            3 => format!("vec3<f32>({})", literal(x)),
            _ => format!("sl_filled({})", literal(x)),
        };
        self.set(dst, value)
    }

    /// The numbers of a value, each by an expression of the operands' numbers.
    fn each(&self, dst: Reg, f: impl Fn(usize) -> String) -> String {
        if dst.width() == 1 {
            return f(0);
        }
        let parts: Vec<String> = (0..dst.width()).map(f).collect();
        format!("{}({})", type_of(dst.width()), parts.join(", "))
    }

    fn unary(&mut self, f: Unary, dst: Reg, a: Reg) -> Done {
        let known = self.registers.constant(a).map(|a| unary_value(f, a));
        if let Some(x) = known.filter(|x| f == Unary::Exp && x.is_infinite()) {
            return self.constant(dst, x);
        }
        let value = match dst.width() {
            16 if f == Unary::Copy => self.registers.spread(a, 16),
            3 if is_for_triples(f) => unary(f, &self.registers.spread(a, 3)),
            _ => self.each(dst, |c| unary(f, &self.registers.component(a, c))),
        };
        self.set(dst, value)
    }

    fn binary(&mut self, f: Binary, dst: Reg, a: Reg, b: Reg) -> Done {
        let plain = matches!(f, Binary::Add | Binary::Sub | Binary::Mul);
        let known = self.registers.constant(a).zip(self.registers.constant(b)).map(|(a, b)| binary_value(f, a, b));
        // WGSL would work this out as well, and has no constants that are infinite.
        if let Some(x) = known.filter(|x| plain && x.is_infinite()) {
            return self.constant(dst, x);
        }
        let value = if plain && dst.width() == 3 && self.registers.is_triple(a, b) {
            // WGSL repeats the number itself.
            binary(f, &self.registers.shortest(a), &self.registers.shortest(b))
        } else {
            self.each(dst, |c| binary(f, &self.registers.component(a, c), &self.registers.component(b, c)))
        };
        self.set(dst, value)
    }

    fn select(&mut self, dst: Reg, c: FloatReg, a: Reg, b: Reg) -> Done {
        let width = dst.width();
        let (a, b) = (self.registers.spread(a, width), self.registers.spread(b, width));
        let c = self.registers.value(c);
        if width < 16 {
            return self.set(dst, format!("select({b}, {a}, {c} != 0.0)"));
        }
        self.set(dst, b)?;
        self.open(format!("if {c} != 0.0"));
        self.set(dst, a)?;
        self.close();
        Ok(())
    }

    /// The condition that an index is that of an element, and the array's element.
    fn element(&self, first: Reg, len: u16, index: FloatReg) -> (String, String) {
        let index = self.registers.value(index);
        let (array, offset) = self.registers.array(first);
        (format!("{index} >= 0.0 && {index} < {len}.0"), format!("{array}[{offset}u + u32({index})]"))
    }

    fn within(&mut self, index: FloatReg, len: u16, place: u32) -> Done {
        let index = self.registers.value(index);
        let outside = format!("!({index} >= 0.0 && {index} < {len}.0)");
        self.open(if self.grid { format!("if on && {outside}") } else { format!("if {outside}") });
        self.line(format!("sl_outside({}u, {place}u);", self.index));
        self.close();
        Ok(())
    }

    fn load(&mut self, dst: Reg, first: Reg, len: u16, index: FloatReg, place: u32) -> Done {
        let (inside, element) = self.element(first, len, index);
        let zero = format!("{}()", type_of(dst.width()));
        self.set(dst, zero)?;
        self.open(format!("if {inside}"));
        self.set(dst, element)?;
        self.between(if self.grid { "else if on" } else { "else" });
        self.line(format!("sl_outside({}u, {place}u);", self.index));
        self.close();
        Ok(())
    }

    fn store(&mut self, first: Reg, len: u16, index: FloatReg, value: Reg, place: u32) -> Done {
        let (inside, element) = self.element(first, len, index);
        let value = self.registers.value(value);
        if self.grid {
            self.open("if on");
        }
        self.open(format!("if {inside}"));
        self.line(format!("{element} = {value};"));
        self.between("else");
        self.line(format!("sl_outside({}u, {place}u);", self.index));
        self.close();
        if self.grid {
            self.close();
        }
        Ok(())
    }

    /// A string that must be known.
    pub fn text(&self, r: TextReg, what: &str) -> Result<String, Refused> {
        match self.texts.get(r) {
            Some(text) => Ok(text.into()),
            None => self.refuse(format!("has {what} that is only known while it runs")),
        }
    }

    fn color_space(&mut self, dst: TripleReg, a: TripleReg, from: TextReg, to: TextReg) -> Done {
        let [from, to] = [from, to].map(|r| self.text(r, "the name of a colour space"));
        let (from, to) = (from?, to?);
        let mut value = self.registers.value(a);
        let stem = |space: &str| match space {
            "hsv" | "hsl" => Some(space.to_string()),
            "xyz" | "XYZ" => Some("xyz".into()),
            "xyY" => Some("xyy".into()),
            "YIQ" => Some("yiq".into()),
            _ => None,
        };
        if let Some(lost) = [&from, &to].into_iter().find(|space| !SPACES.contains(&space.as_str())) {
            return self.refuse(format!("names the colour space `{lost}`, which is unknown"));
        }
        if from != to {
            value = stem(&from).map_or(value.clone(), |from| format!("sl_{from}_to_rgb({value})"));
            value = stem(&to).map_or(value.clone(), |to| format!("sl_rgb_to_{to}({value})"));
        }
        self.set(dst.into(), value)
    }

    fn transform(&mut self, how: Transform, dst: Reg, a: Reg, from: TextReg, to: TextReg) -> Done {
        let [from, to] = [from, to].map(|r| self.text(r, "the name of a coordinate system"));
        let (from, to) = (from?, to?);
        let slot = match how {
            Transform::Normal => Slot::NormalMatrix { from, to },
            _ => Slot::Matrix { from, to },
        };
        let m = format!("sl_read16({}, 0u)", self.slot(slot));
        let a = self.registers.value(a);
        self.set(
            dst,
            match how {
                Transform::Point => format!("sl_point({m}, {a})"),
                Transform::Vector | Transform::Normal => format!("sl_vector({m}, {a})"),
                Transform::Matrix => format!("{m} * {a}"),
            },
        )
    }

    /// A query by name.
    fn ask(&mut self, dst: FloatReg, what: Ask, names: &[TextReg], out: Operand, len: u16) -> Done {
        let names = names.iter().map(|r| self.text(*r, "a name to ask for")).collect::<Result<Vec<_>, _>>()?;
        match (what, out) {
            (Ask::LightSource, Operand::Number(out)) if len == 1 => self.ask_light(dst, &names[0], out),
            (Ask::LightSource, _) => self.refuse("asks a light for a string or an array"),
            (Ask::ShaderName, Operand::Text(_)) if names[0] == "lightsource" => {
                self.refuse("asks for the name of a light")
            }
            (Ask::RayInfo, Operand::Text(_)) => self.refuse("asks for the type of a ray"),
            (_, Operand::Text(_)) => {
                let of: Vec<&str> = names.iter().map(String::as_str).collect();
                let answer = texts::ask(what, &of, self.module.host.scene);
                let found = match &answer {
                    Some(Answer::Text(_)) => true,
                    Some(Answer::Texts(texts)) => texts.len() >= len as usize,
                    _ => false,
                };
                if let Some(message) = asked_in_vain(what, &of, self.module.host.scene).filter(|_| answer.is_none()) {
                    self.warn(message);
                }
                self.module.asked.push((what, names, answer));
                self.set(dst.into(), literal(found as u8 as f32))
            }
            (_, Operand::Number(out)) => {
                let width = out.width();
                let slot = self.slot(Slot::Answer { what, names, width, len: len as usize });
                let found = self.registers.name(dst);
                self.line(format!("{found} = f32(slots[{slot}].y != 0u);"));
                let on = if self.grid { " && on" } else { "" };
                self.open(format!("if {found} != 0.0{on}"));
                for k in 0..len {
                    let name = self.registers.name(out.element(k));
                    self.line(format!("{name} = sl_read{width}({slot}, {k}u);"));
                }
                self.close();
                Ok(())
            }
        }
    }
}
