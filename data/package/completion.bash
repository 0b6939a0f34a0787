# Completion of armukf for bash. What there is to complete is what --help tells at that moment.

_armukf() {
  local program=${COMP_WORDS[0]} word=$2 before=$3 command=estimate help i
  local -a commands options choices
  mapfile -t commands < <("$program" --help 2> /dev/null |
    sed -n '/^Subcommands:/,$ s/^  \([a-z][a-z-]*\) .*/\1/p')
  for ((i = 1; i < COMP_CWORD; ++i)); do
    [[ " ${commands[*]} " != *" ${COMP_WORDS[i]} "* ]] || { command=${COMP_WORDS[i]} && break; }
  done
  help=$("$program" "$command" --help 2> /dev/null)

  # An option's own lines: what may stand behind it is in braces, or a list behind `one of`.
  if [[ $before == -* ]]; then
    mapfile -t choices < <(sed -n "/^  \(-.,\)\?$before[ =:{]/,/^  -/p" <<< "$help" | sed '1!{/^  -/d}' |
      tr '\n' ' ' | sed -n -e 's/^ *--[a-z-]* \([a-z]*|[a-z|]*\).*/\1/p' -e 's/.*:{\([^}>]*\)}.*/\1/p' -e 's/.*one of \([a-z0-9_, ]*\).*/\1/p' |
      tr -d ' ' | tr '|,' '\n')
    ((${#choices[@]} == 0)) || { mapfile -t COMPREPLY < <(compgen -W "${choices[*]}" -- "$word") && return; }
  fi
  if [[ $word == -* ]]; then
    mapfile -t options < <(grep -oE '^  -[^ =:{]+' <<< "$help" | tr -d ' ' | tr ',' '\n')
    mapfile -t COMPREPLY < <(compgen -W "${options[*]}" -- "$word")
  elif ((COMP_CWORD == 1)); then
    mapfile -t COMPREPLY < <(compgen -W "${commands[*]}" -- "$word"; compgen -f -- "$word")
  else
    mapfile -t COMPREPLY < <(compgen -f -- "$word")
  fi
}
complete -o filenames -F _armukf armukf
