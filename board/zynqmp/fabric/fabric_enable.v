// Enables of the amplifiers, and the watchdog that clears them watchdog_us after the last commit at the latest. `tripped` stays set, and
// the enables clear, until a commit whose enables are all 0. Reset is a trip: logic that restarts under running software enables nothing.
//
// An enable is two pins. `enable` is the level. `pulse` is a square wave while the level is 1, for a retriggerable one-shot or a charge
// pump: unlike the level it ends when the clock of the logic stops.
`default_nettype none
module fabric_enable #(
    parameter integer ARMS = 2,
    parameter integer CLOCKS_PER_US = 100,  // 4 to 1023
    parameter integer PULSE_CLOCKS = 500    // half a period of `pulse`, 2 to 65535
) (
    input  wire            clock,
    input  wire            reset,
    input  wire            commit,
    input  wire [ARMS-1:0] wanted,       // enables of this commit
    input  wire [    31:0] watchdog_us,  // 0: never
    output reg  [ARMS-1:0] enable,
    output reg  [ARMS-1:0] pulse,
    output reg             tripped
);
  localparam [9:0] LAST_CLOCK = CLOCKS_PER_US[9:0] - 10'd1;
  localparam [15:0] LAST_PULSE = PULSE_CLOCKS[15:0] - 16'd1;

  reg [31:0] elapsed_us;
  reg [9:0] clocks;  // of the present microsecond
  reg expired;

  reg [15:0] pulse_clocks;
  reg phase;

  wire [ARMS-1:0] next_enable =
      reset || expired || tripped ? {ARMS{1'b0}} : commit ? wanted : enable;

  always @(posedge clock) begin
    enable <= next_enable;
    pulse <= next_enable & {ARMS{phase}};
    if (reset || expired) tripped <= 1'b1;
    if (!reset && commit && wanted == {ARMS{1'b0}}) tripped <= 1'b0;

    // The comparison takes a clock, and so does the enable: the count begins 3 clocks in, and the enable of a commit that no other follows
    // is 1 for watchdog_us less one clock.
    expired <= !reset && !commit && watchdog_us != 32'd0 && elapsed_us >= watchdog_us;
    if (reset || commit) begin
      elapsed_us <= 32'd0;
      clocks <= 10'd3;
    end else if (clocks >= LAST_CLOCK) begin
      clocks <= 10'd0;
      if (elapsed_us != 32'hFFFFFFFF) elapsed_us <= elapsed_us + 32'd1;
    end else clocks <= clocks + 10'd1;

    pulse_clocks <= pulse_clocks == LAST_PULSE ? 16'd0 : pulse_clocks + 16'd1;
    if (pulse_clocks == LAST_PULSE) phase <= !phase;
    if (reset) begin
      pulse_clocks <= 16'd0;
      phase <= 1'b0;
    end
  end

`ifdef PROVE_ENABLE
`include "enable_properties.vh"
`endif
endmodule
`default_nettype wire
