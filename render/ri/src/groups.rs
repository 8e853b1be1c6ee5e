//! Arguments of kinds that one request has, or that later requests depend on.

use crate::arguments::{Arguments, to_rgb};
use crate::params::{Params, Values};
use crate::ri::{Fail, Knots, Tags, TrimCurves};

impl Arguments<'_> {
    /// `Declare`: a name and what it declares, known from here on.
    pub(crate) fn declaration(&mut self) -> Result<(String, String), Fail> {
        let (name, declaration) = (self.text()?, self.text()?);
        self.known.declarations.declare(&name, &declaration).map_err(Fail::new)?;
        Ok((name, declaration))
    }

    /// A frame's number, which conditions may ask for.
    pub(crate) fn frame(&mut self) -> Result<i32, Fail> {
        let number = self.whole()?;
        self.known.conditions.set("Frame", Values::Floats(vec![number as f32]));
        Ok(number)
    }

    /// A group's name and its parameters.
    pub(crate) fn grouped(&mut self) -> Result<(String, Params), Fail> {
        let group = self.text()?;
        let params = self.params_of(&group)?;
        Ok((group, params))
    }

    /// An option's name and parameters, which conditions may ask for.
    pub(crate) fn setting(&mut self) -> Result<(String, Params), Fail> {
        let (name, params) = self.grouped()?;
        for param in &params {
            self.known.conditions.set(&format!("{name}:{}", param.decl.name), param.values.clone());
        }
        Ok((name, params))
    }

    /// f-stop, focal length and distance of a lens; nothing stands for a pinhole.
    pub(crate) fn lens(&mut self) -> Result<[f32; 3], Fail> {
        if self.has_argument()? {
            self.numbers("f-stop, focal length and distance")
        } else {
            Ok([f32::INFINITY, 1.0, 1.0])
        }
    }

    /// A colour or an opacity: red, green and blue, or the samples that `ColorSamples` said.
    pub(crate) fn colour(&mut self) -> Result<[f32; 3], Fail> {
        let Some(samples) = self.known.samples.clone() else { return self.numbers("a colour") };
        let mut values = vec![];
        if self.has_list()? {
            values = self.floats()?;
        } else {
            for _ in &samples {
                values.push(self.number()?);
            }
        }
        let n = values.len();
        to_rgb(&values, &samples)?
            .try_into()
            .map_err(|_| Fail::new(format!("{n} numbers, expected a colour of {} samples", samples.len())))
    }

    /// What colours are from here on: their samples by red, green and blue, and these by samples. The colours of all requests after that are
    /// red, green and blue, and so are what this one says.
    pub(crate) fn colour_samples(&mut self) -> Result<(Vec<f32>, Vec<f32>), Fail> {
        let (to_rgb, from_rgb) = (self.floats()?, self.floats()?);
        if to_rgb.len() != from_rgb.len() || to_rgb.is_empty() || !to_rgb.len().is_multiple_of(3) {
            return Ok((to_rgb, from_rgb));
        }
        self.known.samples = Some(to_rgb.chunks_exact(3).map(|rgb| [rgb[0], rgb[1], rgb[2]]).collect());
        let unit = vec![1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        Ok((unit.clone(), unit))
    }

    /// Two strings.
    pub(crate) fn text_pair(&mut self) -> Result<[String; 2], Fail> {
        Ok([self.text()?, self.text()?])
    }

    /// Six strings.
    pub(crate) fn six_texts(&mut self) -> Result<Vec<String>, Fail> {
        (0..6).map(|_| self.text()).collect()
    }

    /// Points, order, knots and range of a NURBS patch along one parameter.
    pub(crate) fn knots(&mut self) -> Result<Knots, Fail> {
        let (n, order, knots) = (self.whole()?, self.whole()?, self.floats()?);
        Ok(Knots { n, order, knots, range: [self.number()?, self.number()?] })
    }

    /// The nine lists of `TrimCurve`.
    pub(crate) fn trim_curves(&mut self) -> Result<TrimCurves, Fail> {
        Ok(TrimCurves {
            n_curves: self.wholes()?,
            order: self.wholes()?,
            knot: self.floats()?,
            min: self.floats()?,
            max: self.floats()?,
            n: self.wholes()?,
            u: self.floats()?,
            v: self.floats()?,
            w: self.floats()?,
        })
    }

    /// Names, argument counts, integers and floats of tags; without tags the four lists may be left out.
    pub(crate) fn tags(&mut self) -> Result<Tags, Fail> {
        if !self.has_list()? {
            return Ok(Tags::default());
        }
        Ok(Tags { names: self.texts()?, n_args: self.wholes()?, integers: self.wholes()?, floats: self.floats()? })
    }

    /// A basis by name or by matrix (RISpec section 5.3).
    pub(crate) fn basis(&mut self) -> Result<[f32; 16], Fail> {
        let sixth = 1.0 / 6.0;
        if !self.has_text()? {
            return self.numbers("a basis by name or matrix");
        }
        Ok(match self.text()?.as_str() {
            "bezier" => [-1.0, 3.0, -3.0, 1.0, 3.0, -6.0, 3.0, 0.0, -3.0, 3.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
            "b-spline" => [-1.0, 3.0, -3.0, 1.0, 3.0, -6.0, 3.0, 0.0, -3.0, 0.0, 3.0, 0.0, 1.0, 4.0, 1.0, 0.0]
                .map(|x: f32| x * sixth),
            "catmull-rom" => [-1.0, 3.0, -3.0, 1.0, 2.0, -5.0, 4.0, -1.0, -1.0, 0.0, 1.0, 0.0, 0.0, 2.0, 0.0, 0.0]
                .map(|x: f32| x * 0.5),
            "hermite" => [2.0, 1.0, -2.0, 1.0, -3.0, -2.0, 3.0, -1.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
            "power" => [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0],
            other => {
                return Err(Fail::new(format!(
                    "unknown basis `{other}`, expected bezier, b-spline, catmull-rom, hermite or power"
                )));
            }
        })
    }
}
