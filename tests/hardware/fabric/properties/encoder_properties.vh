// Of fabric_encoder, for yosys-smtbmc. The lines are sampled as they come: a line that changes near a clock edge is seen at this edge or
// at the next, so edges that are FILTER + 2 clocks apart are at least FILTER samples apart, which is what is assumed here.
//
// No count is lost or added: in every clock the counter does what a reference decoder does on the unfiltered lines, LATENCY clocks later.
localparam integer LATENCY = FILTER + 2;
reg [7:0] resets = 8'd0;         // clocks of the reset, in which the lines stand still until all of the past is known
reg [LATENCY:0] past_a, past_b;  // bit 0: the last sample
reg [7:0] distance = 8'd0;       // samples since the last edge
wire changed = a != past_a[0] || b != past_b[0];
reg signed [31:0] reference;

// The four states in the order of a cycle forwards: 00, 10, 11, 01.
always @*
  case ({past_a[LATENCY], past_b[LATENCY], past_a[LATENCY-1], past_b[LATENCY-1]})
    4'b0010, 4'b1011, 4'b1101, 4'b0100: reference = 32'd1;
    4'b1000, 4'b1110, 4'b0111, 4'b0001: reference = -32'd1;
    default: reference = 32'd0;
  endcase

always @(posedge clock) begin
  if (resets <= LATENCY) resets <= resets + 8'd1;
  assume (reset == (resets <= LATENCY));
  past_a <= {past_a[LATENCY-1:0], a};
  past_b <= {past_b[LATENCY-1:0], b};
  distance <= changed ? 8'd1 : distance == 8'hFF ? distance : distance + 8'd1;
  if (resets != 8'd0) begin
    if (reset) assume (!changed);
    assume (a == past_a[0] || b == past_b[0]);
    if (changed) assume (distance >= FILTER);
  end
  if (!reset) begin
    assert (now_a == past_a[LATENCY-1] && now_b == past_b[LATENCY-1]);
    assert (was_a == past_a[LATENCY] && was_b == past_b[LATENCY]);
    assert (illegal == 16'd0);
    assert (count == ($past(reset) ? 32'd0 : $past(count) + $past(reference)));
  end
end
