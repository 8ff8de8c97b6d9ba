# Completion of highwall for bash: subcommands, their options and choices as --help names them, else
# files.
_highwall() {
  local word=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]} help words=
  if ((COMP_CWORD == 1)); then
    words=$(highwall --help 2>/dev/null | sed -n '/^Subcommands:/,$s/^  \([a-z-]*\) .*/\1/p')
    words+=" --help --version"
  else
    help=$(highwall "${COMP_WORDS[1]}" --help 2>/dev/null)
    if [[ $word == -* ]]; then
      words=$(grep -o '^  [^ ]*' <<<"$help" | tr ',' '\n' | grep -o -- '--[a-z-]*')
    elif [[ $previous == --* ]]; then  # "--option {a,b,c}" or "TEXT:{a,b,c}"
      words=$(sed -n "s/^  \(-.,\)\?$previous \([A-Z]*:\)\?{\([a-z0-9_,-]*\)}.*/\3/p" <<<"$help")
    fi
  fi
  COMPREPLY=($(compgen -W "${words//,/ }" -- "$word"))
}
complete -o default -F _highwall highwall
