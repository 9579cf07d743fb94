// One input line: synchroniser and filter. `level` takes a new value once LENGTH samples in a row have it, LENGTH + 2 clocks after the
// edge (3 if the edge meets the set-up time of the first flip-flop only just); a shorter pulse is not seen. In reset it follows the line,
// so hold the reset for 4 clocks.
`default_nettype none
module fabric_filter #(
    parameter integer LENGTH = 16  // 2 to 255
) (
    input  wire clock,
    input  wire reset,
    input  wire line,
    output reg  level
);
  localparam [7:0] LAST = LENGTH[7:0] - 8'd1;
  (* ASYNC_REG = "TRUE" *) reg [1:0] sampled;
  reg [7:0] differing;  // samples in a row that differ from the level

  always @(posedge clock) begin
    sampled <= {sampled[0], line};
    differing <= 8'd0;
    if (reset) level <= sampled[1];
    else if (sampled[1] != level) begin
      if (differing >= LAST) level <= sampled[1];
      else differing <= differing + 8'd1;
    end
  end
endmodule
`default_nettype wire
