// Event histories: every event's code goes to a list per path, for the comparison with the CPU twin.

@group(0) @binding(11) var<storage, read_write> events: array<u32>;
var<private> event_row: u32;
var<private> event_count: u32;

fn record(code: u32, margin: f32) {
    if (event_count < EVENTS - 1u) { events[event_row * EVENTS + 1u + event_count] = code; }
    event_count += 1u;
}
fn record_start(row: u32) { event_row = row; event_count = 0u; }
fn record_end(end: u32) {
    record(EVENT_END + end, 1.0);
    events[event_row * EVENTS] = event_count;
}
