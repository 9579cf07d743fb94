_thimble() { mapfile -t COMPREPLY < <(thimble __complete "${COMP_WORDS[@]:1:COMP_CWORD}"); }
complete -F _thimble thimble
