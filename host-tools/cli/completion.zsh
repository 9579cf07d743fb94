#compdef thimble
_thimble() {
  local -a found
  found=("${(@f)$(thimble __complete "${(@)words[2,CURRENT]}")}")
  compadd -- ${found:#:files}
  if (( ${found[(Ie):files]} )); then _files; fi
}
if [[ $funcstack[1] = _thimble ]]; then _thimble "$@"; else compdef _thimble thimble; fi
