//! The REYES renderer: bound, split, dice, displace, shade, sample, filter, display.
