# xsdb flash.tcl ELF PSU_INIT: loads the image over JTAG and starts it. PSU_INIT is the psu_init.tcl of the board's design (pins, clocks, DDR,
# programmable logic's clocks); a part of the code is in DDR. Load the bitstream of the design, if any, before.
#
# Written from the manuals (register names of UG1087), not tested on a board yet. The image runs until power-off;
# docs/board-zynqmp.md says how a boot image keeps it.
lassign $argv elf psu_init
if {$psu_init eq ""} {
  puts stderr "flash.tcl: the board's psu_init.tcl is missing: cmake -D THIMBLE_ZYNQMP_PSU_INIT=FILE"
  exit 1
}
connect
targets -set -nocase -filter {name =~ "*PSU*"}
source $psu_init
psu_init
psu_post_config
psu_ps_pl_isolation_removal
psu_ps_pl_reset_config

# The two cores in lockstep, halted, vectors at 0, tightly coupled memories combined.
set RPU_GLBL_CNTL 0xFF9A0000
set RPU_0_CFG 0xFF9A0100
set RPU_1_CFG 0xFF9A0200
set RST_LPD_TOP 0xFF5E023C
mask_write $RST_LPD_TOP 0x7 0x7
mask_write $RPU_GLBL_CNTL 0x58 0x50
mask_write $RPU_0_CFG 0x5 0x0
mask_write $RPU_1_CFG 0x5 0x0
mask_write $RST_LPD_TOP 0x7 0x0

targets -set -nocase -filter {name =~ "*R5*#0"}
# Words of tightly coupled memory that were never written have invalid ECC.
mwr -force 0x00000000 0 65536
dow $elf
mask_write $RPU_0_CFG 0x1 0x1
con
exit
