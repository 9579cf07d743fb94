// Quadrature decoder of one encoder: four counts per cycle, up while A leads B (as board/common/quadrature.h). No count is lost if edges,
// of A and B together, are at least FILTER + 2 clocks apart. If both lines change in one clock an edge was lost: `illegal` counts that,
// up to 65535.
`default_nettype none
module fabric_encoder #(
    parameter integer FILTER = 16
) (
    input  wire        clock,
    input  wire        reset,
    input  wire        a,
    input  wire        b,
    output reg  [31:0] count,
    output reg  [15:0] illegal
);
  wire now_a, now_b;
  reg was_a, was_b;
  fabric_filter #(.LENGTH(FILTER)) filter_a (.clock(clock), .reset(reset), .line(a), .level(now_a));
  fabric_filter #(.LENGTH(FILTER)) filter_b (.clock(clock), .reset(reset), .line(b), .level(now_b));

  wire edge_a = now_a != was_a;
  wire edge_b = now_b != was_b;
  // After an edge of A the lines differ while A leads; after an edge of B they are equal.
  wire up = edge_a ? now_a != now_b : now_a == now_b;

  always @(posedge clock) begin
    was_a <= now_a;
    was_b <= now_b;
    if (reset) begin
      count   <= 32'd0;
      illegal <= 16'd0;
    end else begin
      if (edge_a != edge_b) count <= up ? count + 32'd1 : count - 32'd1;
      if (edge_a && edge_b && illegal != 16'hFFFF) illegal <= illegal + 16'd1;
    end
  end

`ifdef PROVE_ENCODER
`include "encoder_properties.vh"
`endif
endmodule
`default_nettype wire
