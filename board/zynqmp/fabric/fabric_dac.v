// Motor currents of one arm to an AD5754R (board/common/ad5754.h): outputs A, B, C are the motors 1, 2, 3; SPI mode 1, frames of 24 bits.
// The voltages of the three outputs change together, with the frame `load`. An `update` during a set of frames starts the set again, so
// the converter never shows currents of two commits. `start` sets range and power first.
//
// FULL_SCALE_UA is the current of 10 V, in microamperes. Code: round(current x 32768 / FULL_SCALE_UA), within one step; more than the
// full scale is clamped to it. INVERT: a motor whose amplifier has the other sign.
`default_nettype none
module fabric_dac #(
    parameter [31:0] FULL_SCALE_UA = 32'd10000000,  // 65536 to 33554431
    parameter [2:0] INVERT = 3'b000,
    parameter integer HALF_CLOCKS = 2,           // half a period of SCLK; the data sheet has 33 ns for a whole one
    parameter integer GAP_CLOCKS = 12,           // SYNC high between frames, at least 6
    parameter integer POWER_UP_CLOCKS = 1000     // the outputs need 10 us after the frame that powers them
) (
    input  wire        clock,
    input  wire        reset,
    input  wire        start,
    input  wire        update,
    input  wire        enable,      // 0: currents of zero
    input  wire [95:0] current_uA,  // three of 32 bits, signed
    output reg         sync_n,
    output reg         sclk,
    output reg         sdin
);
  // Bits of a whole number.
  function integer bits(input integer value);
    for (bits = 0; value > 0; bits = bits + 1) value = value >> 1;
  endfunction
  localparam integer SHIFT = bits(FULL_SCALE_UA);
  localparam [63:0] FULL_SCALE = {32'd0, FULL_SCALE_UA};
  localparam [63:0] GAIN = ((64'd32768 << SHIFT) + (FULL_SCALE >> 1)) / FULL_SCALE;
  localparam signed [17:0] STEP_GAIN = GAIN[17:0];  // 2^15 to 2^16
  localparam signed [31:0] MOST = FULL_SCALE_UA;
  localparam signed [43:0] HALF_STEP = 44'sd1 <<< (SHIFT - 1);

  localparam [15:0] GAP = GAP_CLOCKS[15:0] - 16'd1;
  localparam [15:0] POWER_UP = POWER_UP_CLOCKS[15:0] - 16'd1;
  localparam [15:0] HALF = HALF_CLOCKS[15:0] - 16'd1;

  // Steps of a set. The first set after `start` begins with RANGE and ends with POWER, and a second one follows.
  localparam [2:0] RANGE = 3'd0, MOTOR_1 = 3'd1, LOAD = 3'd4, POWER = 3'd5, IDLE = 3'd6;

  // Code of the motor of this step. It is ready 4 clocks after the step began; the gap before a frame is longer.
  reg [2:0] step;
  wire [1:0] motor = step[1:0] - 2'd1;
  wire [31:0] chosen = motor == 2'd0 ? current_uA[31:0] : motor == 2'd1 ? current_uA[63:32] : current_uA[95:64];
  wire inverted = motor == 2'd0 ? INVERT[0] : motor == 2'd1 ? INVERT[1] : INVERT[2];
  reg signed [31:0] wanted_uA;
  reg signed [25:0] clamped_uA;
  reg signed [17:0] gain;
  reg signed [43:0] product;
  wire signed [43:0] steps = (product + HALF_STEP) >>> SHIFT;
  reg [15:0] code;
  always @(posedge clock) begin
    wanted_uA <= enable ? chosen : 32'd0;
    clamped_uA <= wanted_uA[25:0];
    if (wanted_uA > MOST) clamped_uA <= MOST[25:0];
    if (wanted_uA < -MOST) clamped_uA <= -MOST[25:0];
    gain <= inverted ? -STEP_GAIN : STEP_GAIN;
    product <= clamped_uA * gain;
    code <= steps > 44'sd32767 ? 16'h7FFF : steps[15:0];
  end

  reg pending, starting, powered;
  reg [15:0] timer;
  reg [5:0] edges;  // of SCLK, left in this frame; 0: SYNC is high
  reg [22:0] shift;
  reg [23:0] frame;
  always @* begin
    case (step)
      RANGE: frame = 24'h0C0004;
      LOAD: frame = 24'h1D0000;
      POWER: frame = 24'h10001F;
      default: frame = {6'd0, motor, code};
    endcase
  end

  always @(posedge clock) begin
    if (update) pending <= 1'b1;
    if (start) starting <= 1'b1;
    if (timer != 16'd0) timer <= timer - 16'd1;
    else if (step == IDLE) begin
      if (starting || pending) begin
        step <= starting ? RANGE : MOTOR_1;
        timer <= GAP;
        pending <= update;
        starting <= start && !starting;
        if (starting) powered <= 1'b0;
      end
    end else if (sync_n) begin
      sync_n <= 1'b0;
      {sdin, shift} <= frame;
      edges <= 6'd48;
      timer <= HALF;
    end else if (edges != 6'd0) begin
      sclk <= !sclk;
      // The converter samples at the falling edge; data changes with the rising one.
      if (!sclk && edges != 6'd48) {sdin, shift} <= {shift, 1'b0};
      edges <= edges - 6'd1;
      timer <= HALF;
    end else begin
      sync_n <= 1'b1;
      timer <= step == POWER ? POWER_UP : GAP;
      if (starting && step != RANGE) step <= IDLE;
      else if (pending && step < LOAD && step != RANGE) begin
        step <= MOTOR_1;
        pending <= update;
      end else if (step == LOAD) step <= powered ? IDLE : POWER;
      else if (step == POWER) begin
        step <= MOTOR_1;
        powered <= 1'b1;
      end else step <= step + 3'd1;
    end
    if (reset) begin
      sync_n <= 1'b1;
      sclk <= 1'b0;
      sdin <= 1'b0;
      step <= IDLE;
      timer <= 16'd0;
      edges <= 6'd0;
      pending <= 1'b0;
      starting <= 1'b0;
      powered <= 1'b0;
    end
  end
endmodule
`default_nettype wire
