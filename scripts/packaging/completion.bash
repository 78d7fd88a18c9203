# completion.bash: words, options and parameters of vdispd and the programs beside it, as they tell them themselves. zsh takes
# it too: autoload -U bashcompinit; bashcompinit; source this file.
# SPDX-License-Identifier: Apache-2.0

# _vdisp_options PROGRAM [WORD]: options of its --help.
_vdisp_options() { "$@" --help 2>/dev/null | sed -nE 's/^ +(-[^ ]*) .*/\1/p; s/^ +(-[^ ]*)$/\1/p' | tr , '\n'; }
# _vdisp_words PROGRAM: the words of its --help.
_vdisp_words() { "$1" --help 2>/dev/null | sed -nE '/^Subcommands:/,$s/^  ([a-z][a-z-]*) .*/\1/p'; }
# _vdisp_keys STRIP: SECTION.KEY of the installed vdisp.cfg, which has every key; with STRIP the key alone.
_vdisp_keys() {
  sed -nE -e '/^\[/{s/^\[(.*)\].*/\1/;h;d}' -e '/^[A-Za-z]+ *=/{s/ *=.*//;G;s/(.*)\n(.*)/\2.\1/p}' /etc/vdisp/vdisp.cfg 2>/dev/null |
    if [ -n "$1" ]; then sed 's/.*\.//'; else cat; fi
}

_vdisp() {
  local program=$1 word=$2 before=$3 first= i IFS=$'\n'
  COMPREPLY=()
  for ((i = 1; i < COMP_CWORD; i++)); do
    case ${COMP_WORDS[i]} in -*) ;; *) first=${COMP_WORDS[i]}; break ;; esac
  done
  case $before in
    --set)
      # Section names may hold a blank: the whole is quoted.
      COMPREPLY=($(compgen -W "$(_vdisp_keys | sed 's/ /\\ /; s/$/=/')" -- "$word"))
      compopt -o nospace 2>/dev/null
      return ;;
    --cpu) COMPREPLY=($(compgen -W "$(vdispd --version 2>/dev/null | sed -n 's/^instruction sets here: //p' | sed 's/, /\n/g')" -- "$word")); return ;;
    -c | --config | --dot | --file) COMPREPLY=($(compgen -f -- "$word")); compopt -o filenames 2>/dev/null; return ;;
    --dump | --record) COMPREPLY=($(compgen -d -- "$word")); compopt -o filenames 2>/dev/null; return ;;
  esac
  if [[ ${program##*/} = vdispd || ${program##*/} = vdisp-drive ]]; then
    COMPREPLY=($(compgen -W "$(_vdisp_options "$program")" -- "$word"))
  elif [ -z "$first" ]; then
    COMPREPLY=($(compgen -W "$(_vdisp_words "$program")"$'\n'"$(_vdisp_options "$program")" -- "$word"))
  elif [[ $word = -* ]]; then
    COMPREPLY=($(compgen -W "$(_vdisp_options "$program" "$first")" -- "$word"))
  elif [ "${program##*/}" = vdisp-probe ] && [[ $first = [sg]et && $before = "$first" ]]; then
    COMPREPLY=($(compgen -W "$(_vdisp_keys strip)" -- "$word"))
  else
    COMPREPLY=($(compgen -f -- "$word"))
    compopt -o filenames 2>/dev/null
  fi
}
complete -F _vdisp vdispd vdisp-probe vdisp-calibrate vdisp-train vdisp-drive
