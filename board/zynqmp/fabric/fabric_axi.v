// The register block as an AXI4-Lite slave of 4 KiB: the top of the design. One write and one read at a time. Only whole words can be
// written: any other strobe is answered by SLVERR and does nothing. Other words of the 4 KiB read 0, and writes to them do nothing.
`default_nettype none
module fabric_axi #(
    parameter integer ARMS = 2,
    parameter integer CLOCK_HZ = 100000000,      // of aclk: a whole number of MHz, 4 to 500
    parameter integer FILTER = 16,               // samples in a row that make a level of an input
    parameter integer PULSE_CLOCKS = 500,        // half a period of enable_pulse
    parameter [31:0] FULL_SCALE_UA = 32'd10000000,  // motor current at 10 V
    parameter [3*ARMS-1:0] INVERT = {3 * ARMS{1'b0}},
    parameter integer SPI_HALF_CLOCKS = 2,
    parameter integer SPI_GAP_CLOCKS = 12
) (
    input  wire              aclk,
    input  wire              aresetn,
    input  wire [      11:0] s_axi_awaddr,
    input  wire [       2:0] s_axi_awprot,
    input  wire              s_axi_awvalid,
    output wire              s_axi_awready,
    input  wire [      31:0] s_axi_wdata,
    input  wire [       3:0] s_axi_wstrb,
    input  wire              s_axi_wvalid,
    output wire              s_axi_wready,
    output reg  [       1:0] s_axi_bresp,
    output reg               s_axi_bvalid,
    input  wire              s_axi_bready,
    input  wire [      11:0] s_axi_araddr,
    input  wire [       2:0] s_axi_arprot,
    input  wire              s_axi_arvalid,
    output wire              s_axi_arready,
    output wire [      31:0] s_axi_rdata,
    output wire [       1:0] s_axi_rresp,
    output reg               s_axi_rvalid,
    input  wire              s_axi_rready,
    input  wire [3*ARMS-1:0] encoder_a,
    input  wire [3*ARMS-1:0] encoder_b,
    input  wire              e_stop_released,
    input  wire              dead_man_held,
    input  wire [  ARMS-1:0] index,
    input  wire [  ARMS-1:0] drives_good,
    output wire [  ARMS-1:0] enable,
    output wire [  ARMS-1:0] enable_pulse,
    output wire [  ARMS-1:0] dac_sync_n,
    output wire [  ARMS-1:0] dac_sclk,
    output wire [  ARMS-1:0] dac_sdin
);
  localparam [1:0] OKAY = 2'b00, SLVERR = 2'b10;

  reg reset;
  always @(posedge aclk) reset <= !aresetn;

  // Address and data of a write are taken in the same clock, and its answer follows; no write is taken while an answer waits.
  wire take_write = !reset && s_axi_awvalid && s_axi_wvalid && !s_axi_bvalid;
  assign s_axi_awready = take_write;
  assign s_axi_wready  = take_write;
  wire take_read = !reset && s_axi_arvalid && !s_axi_rvalid;
  wire write = take_write && s_axi_wstrb == 4'hF;
  assign s_axi_arready = take_read;
  assign s_axi_rresp   = OKAY;

  always @(posedge aclk) begin
    if (take_write) begin
      s_axi_bvalid <= 1'b1;
      s_axi_bresp  <= s_axi_wstrb == 4'hF ? OKAY : SLVERR;
    end else if (s_axi_bready) s_axi_bvalid <= 1'b0;
    if (take_read) s_axi_rvalid <= 1'b1;
    else if (s_axi_rready) s_axi_rvalid <= 1'b0;
    if (!aresetn || reset) begin
      s_axi_bvalid <= 1'b0;
      s_axi_rvalid <= 1'b0;
    end
  end

  fabric_registers #(
      .ARMS(ARMS), .CLOCK_HZ(CLOCK_HZ), .FILTER(FILTER), .PULSE_CLOCKS(PULSE_CLOCKS), .FULL_SCALE_UA(FULL_SCALE_UA), .INVERT(INVERT),
      .SPI_HALF_CLOCKS(SPI_HALF_CLOCKS), .SPI_GAP_CLOCKS(SPI_GAP_CLOCKS)
  ) registers (
      .clock(aclk), .reset(reset),
      .write(write), .write_word(s_axi_awaddr[11:2]), .write_data(s_axi_wdata),
      .read(take_read), .read_word(s_axi_araddr[11:2]), .read_data(s_axi_rdata),
      .encoder_a(encoder_a), .encoder_b(encoder_b), .e_stop_released(e_stop_released), .dead_man_held(dead_man_held),
      .index(index), .drives_good(drives_good), .enable(enable), .enable_pulse(enable_pulse),
      .dac_sync_n(dac_sync_n), .dac_sclk(dac_sclk), .dac_sdin(dac_sdin));

  // Word addresses alone matter, and protection does not.
  wire unused = &{1'b0, s_axi_awprot, s_axi_arprot, s_axi_awaddr[1:0], s_axi_araddr[1:0]};

`ifdef PROVE_AXI
`include "axi_properties.vh"
`endif
endmodule
`default_nettype wire
