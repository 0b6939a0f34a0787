#compdef armukf
# Completion of armukf for zsh. What there is to complete is what --help tells at that moment.

local -a commands options
local command=estimate
commands=(${(f)"$($words[1] --help 2> /dev/null |
  sed -n '/^Subcommands:/,$ s/^  \([a-z][a-z-]*\)  *\(.*\)/\1:\2/p')"})
(( CURRENT > 2 && ${commands[(I)$words[2]:*]} )) && command=$words[2]

if [[ $PREFIX == -* ]]; then
  options=(${(f)"$($words[1] $command --help 2> /dev/null |
    sed -n -e 's/^  \(-.,\)\{0,1\}\(--[a-z-]*\)\(.\{0,24\}  *\)\{0,1\}\(.*\)/\2:\4/p')"})
  _describe -o option options
elif (( CURRENT == 2 )); then
  _describe command commands
  _files
else
  _files
fi
