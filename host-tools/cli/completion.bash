_thimble() {
  local found word
  mapfile -t found < <(thimble __complete "${COMP_WORDS[@]:1:COMP_CWORD}")
  COMPREPLY=()
  for word in "${found[@]}"; do
    if [ "$word" = :files ]; then
      compopt -o filenames 2>/dev/null
      mapfile -t -O "${#COMPREPLY[@]}" COMPREPLY < <(compgen -f -- "${COMP_WORDS[COMP_CWORD]}")
    else
      COMPREPLY+=("$word")
    fi
  done
}
complete -F _thimble thimble
