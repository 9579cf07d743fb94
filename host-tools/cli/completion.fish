function __thimble_complete
  set -l words (commandline -opc)
  for word in (thimble __complete $words[2..-1] (commandline -ct))
    if test "$word" = :files
      __fish_complete_path (commandline -ct)
    else
      echo $word
    end
  end
end
complete -c thimble -f -a '(__thimble_complete)'
