// Sums in 64-bit fixed point, so that they do not depend on the order: two u32 with carry.

struct Fixed { low: u32, high: u32 }

const FULL: u32 = 0xffffffffu;   // of a high word: the sum, or what was added, did not fit

// v >= 0 with 2^32 units to one; exact for a 24-bit significand of 2^-8 and more. FULL from 2^32 on.
fn to_fixed(v: f32) -> Fixed {
    if (v >= 4294967296.0) { return Fixed(FULL, FULL); }
    let whole = floor(v);
    let part = (v - whole) * 4294967296.0;
    return Fixed(select(u32(part), 0xffffffffu, part >= 4294967296.0), u32(whole));
}

// Stays FULL once it is: a sum that wrapped would look like any other.
fn add_fixed(x: Fixed, y: Fixed) -> Fixed {
    let low = x.low + y.low;
    let carry = select(0u, 1u, low < x.low);
    let high = x.high + y.high + carry;
    if (max(x.high, y.high) == FULL || high < x.high || high < y.high) { return Fixed(FULL, FULL); }
    return Fixed(low, high);
}

var<private> lost: bool;
fn record_lost() { lost = true; }
fn lost_here() -> bool { let was = lost; lost = false; return was; }
