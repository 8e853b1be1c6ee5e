//! Texts: how wide they are, and their glyphs, from the open fonts Ubuntu Light and, for what that lacks, Hack.

use super::canvas::{Canvas, Ink, Place};
use ab_glyph::{Font, FontRef, ScaleFont};
use std::sync::LazyLock;

/// The fonts, in the order in which a character is looked for.
static FONTS: LazyLock<Vec<FontRef<'static>>> = LazyLock::new(|| {
    let all = [epaint_default_fonts::UBUNTU_LIGHT, epaint_default_fonts::HACK_REGULAR];
    all.into_iter().map(|bytes| FontRef::try_from_slice(bytes).expect("the fonts are built in")).collect()
});

/// The font that has a character.
fn font_of(c: char) -> Option<&'static FontRef<'static>> {
    FONTS.iter().find(|font| font.glyph_id(c).0 != 0)
}

/// The first character of a text that no font has.
pub fn unknown(text: &str) -> Option<char> {
    text.chars().find(|c| font_of(*c).is_none())
}

/// Each character that is drawn of a text: its font, its glyph and where it begins, ems.
fn placed(text: &str) -> (Vec<(&'static FontRef<'static>, ab_glyph::GlyphId, f32)>, f32) {
    let (mut all, mut x): (Vec<(&'static FontRef<'static>, ab_glyph::GlyphId, f32)>, f32) = (vec![], 0.0);
    for (font, id) in text.chars().filter_map(|c| font_of(c).map(|font| (font, font.glyph_id(c)))) {
        let scaled = font.as_scaled(1.0);
        if let Some((before, last, _)) = all.last()
            && std::ptr::eq(*before, font)
        {
            x += scaled.kern(*last, id);
        }
        all.push((font, id, x));
        x += scaled.h_advance(id);
    }
    (all, x)
}

/// The width of a text, ems.
pub fn width(text: &str) -> f32 {
    placed(text).1
}

/// Draw a text from the left end of its baseline; an em has so many pixels.
pub fn draw(canvas: &mut Canvas<'_>, text: &str, [x, y]: Place, em: f32, ink: Ink) {
    for (font, id, from) in placed(text).0 {
        let glyph = id.with_scale_and_position(em, ab_glyph::point(x + from * em, y));
        let Some(outlined) = font.outline_glyph(glyph) else { continue };
        let corner = outlined.px_bounds().min;
        outlined.draw(|dx, dy, cover| {
            // Processors differ in the last bits. Thin strokes are drawn a little stronger, which keeps small texts legible.
            let cover = (cover.clamp(0.0, 1.0).powf(0.75) * 64.0).round() / 64.0;
            canvas.blend(corner.x as i64 + dx as i64, corner.y as i64 + dy as i64, ink, cover);
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_have_widths_and_known_characters() {
        assert!(width("mm") > 1.9 * width("m") && width("") == 0.0);
        assert_eq!([unknown("t = 0.5 µs, 20 °C, m/s², −3·10⁶ Ω α→β"), unknown("a漢b")], [None, Some('漢')]);
        // Digits are equally wide: a time that runs does not jitter.
        let widths = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9].map(|d: u32| width(&d.to_string()));
        assert!(widths.iter().all(|w| (w - widths[0]).abs() < 1e-4), "{widths:?}");
    }
}
