// The register block of docs/board-cortex.md behind a simple bus: a write takes effect in the clock of `write`; the answer to `read`
// is in read_data in the next clock and stays there. Addresses are of words. docs/fabric.md has the pins and the parameters.
`default_nettype none
module fabric_registers #(
    parameter integer ARMS = 2,
    parameter integer CLOCK_HZ = 100000000,
    parameter integer FILTER = 16,
    parameter integer PULSE_CLOCKS = 500,
    parameter [31:0] FULL_SCALE_UA = 32'd10000000,
    parameter [3*ARMS-1:0] INVERT = {3 * ARMS{1'b0}},
    parameter integer SPI_HALF_CLOCKS = 2,
    parameter integer SPI_GAP_CLOCKS = 12
) (
    input  wire                clock,
    input  wire                reset,
    input  wire                write,
    input  wire [         9:0] write_word,
    input  wire [        31:0] write_data,
    input  wire                read,
    input  wire [         9:0] read_word,
    output reg  [        31:0] read_data,
    // Per arm a, joint j: bit 3 a + j.
    input  wire [  3*ARMS-1:0] encoder_a,
    input  wire [  3*ARMS-1:0] encoder_b,
    input  wire                e_stop_released,
    input  wire                dead_man_held,
    input  wire [    ARMS-1:0] index,
    input  wire [    ARMS-1:0] drives_good,
    output wire [    ARMS-1:0] enable,
    output wire [    ARMS-1:0] enable_pulse,
    output wire [    ARMS-1:0] dac_sync_n,
    output wire [    ARMS-1:0] dac_sclk,
    output wire [    ARMS-1:0] dac_sdin
);
  localparam integer JOINTS = 3 * ARMS;
  localparam [31:0] ID = 32'h424D4854, VERSION = 32'd2, WATCHDOG_AT_RESET = 32'd2000;
  localparam [9:0] WORD_ID = 10'd0, WORD_VERSION = 10'd1, WORD_LATCH = 10'd2, WORD_LINES = 10'd3, WORD_COMMIT = 10'd4,
      WORD_WATCHDOG = 10'd5, WORD_ARMS = 10'd8, WORD_DIAGNOSTICS = 10'd64;

  // Inputs.
  wire [1:0] line;
  wire [ARMS-1:0] at_index, good;
  fabric_filter #(.LENGTH(FILTER)) filter_e_stop (
      .clock(clock), .reset(reset), .line(e_stop_released), .level(line[0]));
  fabric_filter #(.LENGTH(FILTER)) filter_dead_man (
      .clock(clock), .reset(reset), .line(dead_man_held), .level(line[1]));
  wire [32*JOINTS-1:0] count;
  wire [16*JOINTS-1:0] illegal;
  genvar g;
  generate
    for (g = 0; g < JOINTS; g = g + 1) begin : encoders
      fabric_encoder #(.FILTER(FILTER)) encoder (
          .clock(clock), .reset(reset), .a(encoder_a[g]), .b(encoder_b[g]),
          .count(count[32*g+:32]), .illegal(illegal[16*g+:16]));
    end
    for (g = 0; g < ARMS; g = g + 1) begin : arm_lines
      fabric_filter #(.LENGTH(FILTER)) filter_index (
          .clock(clock), .reset(reset), .line(index[g]), .level(at_index[g]));
      fabric_filter #(.LENGTH(FILTER)) filter_good (
          .clock(clock), .reset(reset), .line(drives_good[g]), .level(good[g]));
    end
  endgenerate

  // Writes.
  wire latch = write && write_word == WORD_LATCH;
  wire commit = write && write_word == WORD_COMMIT;
  reg [31:0] watchdog_us;
  reg [32*JOINTS-1:0] staged_uA, current_uA;
  reg [ARMS-1:0] staged_enable;
  integer a, j;
  always @(posedge clock) begin
    if (write && write_word == WORD_WATCHDOG) watchdog_us <= write_data;
    for (a = 0; a < ARMS; a = a + 1) begin
      for (j = 0; j < 3; j = j + 1)
        if (write && write_word == WORD_ARMS + 10'd8 * a[9:0] + 10'd4 + j[9:0]) staged_uA[32*(3*a+j)+:32] <= write_data;
      if (write && write_word == WORD_ARMS + 10'd8 * a[9:0] + 10'd7) staged_enable[a] <= write_data[0];
    end
    if (commit) current_uA <= staged_uA;
    if (reset) begin
      watchdog_us <= WATCHDOG_AT_RESET;
      staged_uA <= {32 * JOINTS{1'b0}};
      staged_enable <= {ARMS{1'b0}};
      current_uA <= {32 * JOINTS{1'b0}};
    end
  end

  wire tripped;
  fabric_enable #(.ARMS(ARMS), .CLOCKS_PER_US(CLOCK_HZ / 1000000), .PULSE_CLOCKS(PULSE_CLOCKS)) enables (
      .clock(clock), .reset(reset), .commit(commit), .wanted(staged_enable), .watchdog_us(watchdog_us),
      .enable(enable), .pulse(enable_pulse), .tripped(tripped));

  // The converters follow commits and trips, in the clock after. They are set up when a trip ends: at the first commit after reset too.
  reg committed, was_tripped;
  always @(posedge clock) begin
    committed <= commit && !reset;
    was_tripped <= tripped || reset;
  end
  wire dac_update = committed || (tripped && !was_tripped);
  wire dac_start = was_tripped && !tripped;
  generate
    for (g = 0; g < ARMS; g = g + 1) begin : converters
      fabric_dac #(
          .FULL_SCALE_UA(FULL_SCALE_UA), .INVERT(INVERT[3*g+:3]), .HALF_CLOCKS(SPI_HALF_CLOCKS), .GAP_CLOCKS(SPI_GAP_CLOCKS),
          .POWER_UP_CLOCKS(CLOCK_HZ / 100000)
      ) dac (
          .clock(clock), .reset(reset), .start(dac_start), .update(dac_update), .enable(enable[g]),
          .current_uA(current_uA[96*g+:96]), .sync_n(dac_sync_n[g]), .sclk(dac_sclk[g]), .sdin(dac_sdin[g]));
    end
  endgenerate

  // What reads see: counters and lines of the instant of the latch.
  reg [32*JOINTS-1:0] latched_count;
  reg [1:0] latched_line;
  reg [ARMS-1:0] latched_index, latched_good;
  always @(posedge clock) begin
    if (latch) begin
      latched_count <= count;
      latched_line <= line;
      latched_index <= at_index;
      latched_good <= good & ~{ARMS{tripped}};
    end
    if (reset) begin
      latched_count <= {32 * JOINTS{1'b0}};
      latched_line <= 2'd0;
      latched_index <= {ARMS{1'b0}};
      latched_good <= {ARMS{1'b0}};
    end
  end

  // The counters of an arm in the clock in which its index begins, and how many there were.
  reg [32*JOINTS-1:0] index_count;
  reg [16*ARMS-1:0] indices;
  reg [ARMS-1:0] was_at_index;
  integer i;
  always @(posedge clock) begin
    was_at_index <= at_index;
    for (i = 0; i < ARMS; i = i + 1)
      if (at_index[i] && !was_at_index[i]) begin
        index_count[96*i+:96] <= count[96*i+:96];
        indices[16*i+:16] <= indices[16*i+:16] + 16'd1;
      end
    if (reset) begin
      index_count <= {32 * JOINTS{1'b0}};
      indices <= {16 * ARMS{1'b0}};
    end
  end

  // At most one of these words has the address, and all others are 0.
  reg [31:0] found;
  integer r, k;
  always @* begin
    found = 32'd0;
    if (read_word == WORD_ID) found = ID;
    if (read_word == WORD_VERSION) found = VERSION;
    if (read_word == WORD_LINES) found = {30'd0, latched_line};
    for (r = 0; r < ARMS; r = r + 1) begin
      for (k = 0; k < 3; k = k + 1) begin
        if (read_word == WORD_ARMS + 10'd8 * r[9:0] + k[9:0]) found = latched_count[32*(3*r+k)+:32];
        if (read_word == WORD_DIAGNOSTICS + 10'd8 * r[9:0] + k[9:0]) found = {16'd0, illegal[16*(3*r+k)+:16]};
        if (read_word == WORD_DIAGNOSTICS + 10'd8 * r[9:0] + 10'd4 + k[9:0]) found = index_count[32*(3*r+k)+:32];
      end
      if (read_word == WORD_ARMS + 10'd8 * r[9:0] + 10'd3) found = {30'd0, latched_good[r], latched_index[r]};
      if (read_word == WORD_DIAGNOSTICS + 10'd8 * r[9:0] + 10'd3) found = {16'd0, indices[16*r+:16]};
      if (read_word == WORD_DIAGNOSTICS + 10'd8 * r[9:0] + 10'd7) found = {30'd0, tripped, enable[r]};
    end
  end
  always @(posedge clock) if (read) read_data <= found;

`ifdef PROVE_REGISTERS
`include "registers_properties.vh"
`endif
endmodule
`default_nettype wire
