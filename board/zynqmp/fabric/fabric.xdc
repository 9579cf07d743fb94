# Untested, as build.tcl. Inputs have no relation to the clock: their first flip-flop is the synchroniser's.
set_false_path -to [get_pins -hierarchical -filter {NAME =~ *sampled_reg[0]/D}]
set_false_path -to [get_ports {enable* dac_sync_n* dac_sclk* dac_sdin*}]
# Beside the resistors on the board, not instead of them: these begin when the logic is loaded.
set_property PULLDOWN TRUE [get_ports {enable* e_stop_released dead_man_held index* drives_good*}]
