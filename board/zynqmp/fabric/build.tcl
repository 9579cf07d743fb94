# vivado -mode batch -source build.tcl -tclargs PART PINS.xdc: the register block behind the processor of a Zynq UltraScale+, at 0x80000000.
# A sketch: it has never run (docs/fabric.md). Set the processor's DDR, MIO and clocks for your board, for example with its board file.
lassign $argv part pins
set here [file dirname [file normalize [info script]]]
create_project fabric fabric.vivado -part $part -force
add_files [glob $here/*.v]
add_files -fileset constrs_1 $pins
add_files -fileset constrs_1 $here/fabric.xdc

create_bd_design system
set ps [create_bd_cell -type ip -vlnv xilinx.com:ip:zynq_ultra_ps_e ps]
set_property -dict {
  CONFIG.PSU__USE__M_AXI_GP0 0 CONFIG.PSU__USE__M_AXI_GP1 0 CONFIG.PSU__USE__M_AXI_GP2 1
  CONFIG.PSU__MAXIGP2__DATA_WIDTH 32 CONFIG.PSU__FPGA_PL0_ENABLE 1 CONFIG.PSU__CRL_APB__PL0_REF_CTRL__FREQMHZ 100
} $ps
set reset [create_bd_cell -type ip -vlnv xilinx.com:ip:proc_sys_reset reset]
set bus [create_bd_cell -type ip -vlnv xilinx.com:ip:smartconnect bus]
set_property CONFIG.NUM_SI 1 $bus
set fabric [create_bd_cell -type module -reference fabric_axi fabric]

set clock [get_bd_pins ps/pl_clk0]
foreach pin {ps/maxihpm0_lpd_aclk reset/slowest_sync_clk bus/aclk fabric/aclk} { connect_bd_net $clock [get_bd_pins $pin] }
connect_bd_net [get_bd_pins ps/pl_resetn0] [get_bd_pins reset/ext_reset_in]
foreach pin {bus/aresetn fabric/aresetn} { connect_bd_net [get_bd_pins reset/peripheral_aresetn] [get_bd_pins $pin] }
connect_bd_intf_net [get_bd_intf_pins ps/M_AXI_HPM0_LPD] [get_bd_intf_pins bus/S00_AXI]
connect_bd_intf_net [get_bd_intf_pins bus/M00_AXI] [get_bd_intf_pins fabric/s_axi]
foreach pin {encoder_a encoder_b e_stop_released dead_man_held index drives_good enable enable_pulse dac_sync_n dac_sclk dac_sdin} {
  make_bd_pins_external -name $pin [get_bd_pins fabric/$pin]
}
assign_bd_address -offset 0x80000000 -range 4K [get_bd_addr_segs fabric/s_axi/reg0]
validate_bd_design

make_wrapper -files [get_files system.bd] -top -import
set_property top system_wrapper [current_fileset]
launch_runs impl_1 -to_step write_bitstream
wait_on_run impl_1
open_run impl_1
report_timing_summary -file timing.txt
report_utilization -file utilization.txt
if {[get_property SLACK [get_timing_paths]] < 0} { error "the logic does not meet its clock: timing.txt" }
write_hw_platform -fixed -include_bit -force fabric.xsa
