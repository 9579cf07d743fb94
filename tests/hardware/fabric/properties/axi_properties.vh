// Of fabric_axi, for yosys-smtbmc: a master that may do anything.
reg started = 1'b0;
always @(posedge aclk) begin
  started <= 1'b1;
  if (!started) assume (!aresetn);
  if (!started) assume (reset);
  // Nothing is taken that is not there, and address and data of a write together.
  assert (s_axi_awready == s_axi_wready);
  if (s_axi_awready) assert (s_axi_awvalid && s_axi_wvalid && !s_axi_bvalid);
  if (s_axi_arready) assert (s_axi_arvalid && !s_axi_rvalid);
  // Nobody waits: what is there is taken unless an answer waits.
  if (!reset && s_axi_awvalid && s_axi_wvalid && !s_axi_bvalid) assert (s_axi_awready);
  if (!reset && s_axi_arvalid && !s_axi_rvalid) assert (s_axi_arready);
  // The block sees each write once, if it is of a whole word.
  assert (write == (s_axi_awready && s_axi_awvalid && s_axi_wstrb == 4'hF));
  if (started && $past(aresetn) && !$past(reset)) begin
    // One answer for each, which stays until it is taken.
    assert (s_axi_bvalid == ($past(s_axi_awready) || ($past(s_axi_bvalid) && !$past(s_axi_bready))));
    assert (s_axi_rvalid == ($past(s_axi_arready) || ($past(s_axi_rvalid) && !$past(s_axi_rready))));
    if ($past(s_axi_bvalid && !s_axi_bready)) assert (s_axi_bresp == $past(s_axi_bresp));
    if ($past(s_axi_rvalid && !s_axi_rready)) assert (s_axi_rdata == $past(s_axi_rdata));
    if ($past(s_axi_awready)) assert (s_axi_bresp == ($past(s_axi_wstrb) == 4'hF ? OKAY : SLVERR));
  end
  if (started && $past(!aresetn || reset)) assert (!s_axi_bvalid && !s_axi_rvalid);
end
