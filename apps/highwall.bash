# Completion of highwall for bash: subcommands, their options and choices as --help names them, else
# files.
_highwall() {
  local word=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]}
  COMPREPLY=()
  if ((COMP_CWORD == 1)); then
    local commands
    commands=$(highwall --help 2>/dev/null | sed -n '/^Subcommands:/,$s/^  \([a-z-]*\) .*/\1/p')
    mapfile -t COMPREPLY < <(compgen -W "$commands --help --version" -- "$word")
    return
  fi
  local help
  help=$(highwall "${COMP_WORDS[1]}" --help 2>/dev/null)
  if [[ $word == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$(grep -o -- '^  [^ ]*' <<<"$help" | tr ',' '\n' |
      grep -o -- '--[a-z-]*')" -- "$word")
  elif [[ $previous == --* ]]; then
    # "--option TEXT:{a,b,c}"
    local choices
    choices=$(sed -n "s/^  \(-.,\)\?$previous [A-Z]*:{\([a-z0-9_,-]*\)}.*/\2/p" <<<"$help")
    mapfile -t COMPREPLY < <(compgen -W "${choices//,/ }" -- "$word")
  fi
}
complete -o default -F _highwall highwall
