// Sums in 64-bit fixed point, so that they do not depend on the order: two u32 with carry.

struct Fixed { low: u32, high: u32 }

// v >= 0 with 2^32 units to one; exact for a 24-bit significand of 2^-8 and more.
fn to_fixed(v: f32) -> Fixed {
    let whole = floor(v);
    let part = (v - whole) * 4294967296.0;
    return Fixed(select(u32(part), 0xffffffffu, part >= 4294967296.0), u32(whole));
}

fn add_fixed(x: Fixed, y: Fixed) -> Fixed {
    let low = x.low + y.low;
    return Fixed(low, x.high + y.high + select(0u, 1u, low < x.low));
}

var<private> lost: bool;
fn record_lost() { lost = true; }
fn lost_here() -> bool { let was = lost; lost = false; return was; }
