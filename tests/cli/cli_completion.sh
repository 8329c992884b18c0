#!/usr/bin/env bash
# Completion of bash, zsh and fish: what each offers is what the help lists.
set -u
. tests/support/tap.sh

commands=$("$ricochet" --help | awk '/^  [a-z]+  / { print $1 }')
for shell in bash zsh fish; do "$ricochet" --completion "$shell" >"$folder/$shell"; done
touch "$folder/mine.ricochet"

# offers SHELL WORD...: what is offered for the last word, which may be empty
offers_bash() {
    bash --norc --noprofile -c '. "$1"; shift; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _ricochet; printf "%s\n" "${COMPREPLY[@]}"' \
        bash "$folder/bash" "$@" | sed 's/ *$//'
}
offers_fish() { fish --no-config -c 'source $argv[1]; complete -C "$argv[2]"' "$folder/fish" "$*" | cut -f1 | sed 's/=$//'; }
# zsh completes in a terminal only: its own functions are asked what they are told
zsh_stubs='compdef() { :; }
    _arguments() { for spec; do print -r -- ${${${spec#\*}%%[=+\[:]*}}; print -r -- "words $spec"; done }
    _describe() { for pair in ${(P)2}; do print -r -- ${pair%%:*}; done }
    compadd() { print -rl -- "$@"; }'
offers_zsh() {
    local words
    words=$(printf '%q ' "$@")
    zsh -f -c "$zsh_stubs
        source '$folder/zsh'
        words=($words) CURRENT=$#
        _ricochet"
}
# each_SHELL COMMAND...: lines `COMMAND OPTION` of all that is offered behind - and --, by one shell
each_bash() {
    bash --norc --noprofile -c '. "$1"; shift
        for one; do
            for word in - --; do
                COMP_WORDS=(ricochet "$one" "$word") COMP_CWORD=2 COMPREPLY=()
                _ricochet
                printf "$one %s\n" "${COMPREPLY[@]}"
            done
        done' bash "$folder/bash" "$@" | sed 's/ *$//'
}
each_fish() {
    fish --no-config -c 'source $argv[1]
        for one in $argv[2..-1]
            for word in - --
                for line in (complete -C "ricochet $one $word")
                    echo $one (string replace -r "\t.*" "" -- $line | string replace -r "=\$" "")
                end
            end
        end' "$folder/fish" "$@"
}
each_zsh() {
    zsh -f -c "$zsh_stubs
        source '$folder/zsh'
        for one; do
            for word in - --; do
                words=(ricochet \$one \$word) CURRENT=3
                _ricochet | sed \"s/^/\$one /\"
            done
        done" zsh "$@"
}
# What is to be offered.
sorted() { LC_ALL=C sort -u; }
for command in $commands; do
    [ "$command" = plot ] || "$ricochet" "$command" --help | sed -nE "s/^  (-[-a-z]+).*/$command \1/p"
done | sorted >"$folder/options"
ok 'there are options' test "$(wc -l <"$folder/options")" -gt 150
all() { # SHELL: every command, and of each every option of its help
    offers_"$1" ricochet '' | sorted >"$folder/offered"
    printf '%s\n' $commands | sorted | LC_ALL=C comm -23 - "$folder/offered" >"$folder/lacking"
    each_"$1" $commands | sorted | LC_ALL=C comm -23 "$folder/options" - >>"$folder/lacking"
    sed 's/$/ is not offered/' "$folder/lacking"
    [ ! -s "$folder/lacking" ]
}
offered() { local shell=$1 word=$2; shift 2; offers_"$shell" "$@" >"$folder/offered"; cat "$folder/offered"; grep -qx -e "$word" "$folder/offered"; }
not_offered() { ! offered "$@"; }

for shell in bash zsh fish; do
    if ! command -v "$shell" >/dev/null; then
        left_out "completion of $shell" "$shell is missing"
        continue
    fi
    ok "$shell reads its script" "$shell" -n "$folder/$shell"
    ok "$shell: every command and option" all "$shell"
    ok "$shell: the pictures" offered "$shell" fep ricochet plot ''
    ok "$shell: the options of a picture" offered "$shell" --histories ricochet plot orbits --
    ok "$shell: not those of another" not_offered "$shell" --histories ricochet plot fep --
done
if command -v fish >/dev/null; then
    ok 'fish: fixed words' offered fish named ricochet plot fep --labels ''
    ok 'fish: files' offered fish "$folder/mine.ricochet" ricochet branches "$folder/mi"
    ok 'fish: no files where a number is wanted' not_offered fish "$folder/mine.ricochet" ricochet run --max-step "$folder/mi"
fi
if command -v zsh >/dev/null; then
    ok 'zsh: fixed words' eval "offers_zsh ricochet plot fep -- | grep -q 'WHAT:(all named none)'"
    ok 'zsh: words of the program' offered zsh fish ricochet --completion ''
fi
ok 'bash: fixed words' offered bash named ricochet plot fep --labels ''
ok 'bash: fixed words behind =' offered bash named ricochet plot fep --labels = na
ok 'bash: files' offered bash "$folder/mine.ricochet" ricochet branches "$folder/mi"
ok 'bash: no files where a number is wanted' not_offered bash "$folder/mine.ricochet" ricochet run --max-step "$folder/mi"

# The same as a user has it: keys that are typed in a terminal, and what then stands on its screen.
screen() { tmux -S "$folder/tmux" capture-pane -p -J -t "$1"; }
appears() { # SHELL TEXT: waits for it, for two minutes
    for _ in $(seq 1200); do
        screen "$1" >"$folder/screen" || return 1
        ! grep -qF -e "$2" "$folder/screen" || return 0
        sleep 0.1
    done
    sed -n '/./s/^/screen: /p' "$folder/screen"
    return 1
}
typed() { # SHELL KEYS TEXT: the keys, and the tabulator; the line is then taken away
    tmux -S "$folder/tmux" send-keys -t "$1" -l "$2" && tmux -S "$folder/tmux" send-keys -t "$1" Tab && appears "$1" "$3" &&
        tmux -S "$folder/tmux" send-keys -t "$1" C-u C-l
}
mkdir -p "$folder/home/functions" "$folder/bin"
ln -sf "$(realpath "$ricochet")" "$folder/bin/ricochet"
cp "$folder/zsh" "$folder/home/functions/_ricochet"
printf '%s\n' "PS1='ready> '" ". '$folder/bash'" >"$folder/home/bashrc"
printf '%s\n' "PS1='ready> '" "fpath=('$folder/home/functions' \$fpath)" 'autoload -Uz compinit' "compinit -u -d '$folder/home/dump'" >"$folder/home/.zshrc"
printf '%s\n' "source '$folder/fish'" "function fish_prompt; printf 'ready> '; end" >"$folder/home/config.fish"
terminal_of() { # SHELL: its command, without what the user has set
    case $1 in
    bash) echo "bash --noprofile --rcfile '$folder/home/bashrc' -i" ;;
    zsh) echo "zsh -d -i" ;;
    fish) echo "fish --no-config --init-command 'source $folder/home/config.fish'" ;;
    esac
}
# A server whose last session is over ends: one stays until all have been. Its surroundings are those of all sessions.
! command -v tmux >/dev/null ||
    env -u TMUX HOME="$folder/home" ZDOTDIR="$folder/home" XDG_CONFIG_HOME="$folder/home" XDG_DATA_HOME="$folder/home" PATH="$folder/bin:$PATH" LC_ALL=C.UTF-8 \
        tmux -S "$folder/tmux" -f /dev/null new-session -d -s stays cat
for shell in bash zsh fish; do
    if ! command -v "$shell" >/dev/null || ! command -v tmux >/dev/null; then
        left_out "$shell in a terminal" "$shell or tmux is missing"
        continue
    fi
    tmux -S "$folder/tmux" new-session -d -x 200 -y 40 -s "$shell" "$(terminal_of "$shell")"
    ok "$shell starts in a terminal" appears "$shell" 'ready>'
    ok "$shell in a terminal: a command" typed "$shell" 'ricochet branc' 'ricochet branches'
    ok "$shell in a terminal: a picture" typed "$shell" 'ricochet plot fe' 'ricochet plot fep'
    ok "$shell in a terminal: an option" typed "$shell" 'ricochet run --max-st' 'ricochet run --max-step'
    ok "$shell in a terminal: a file" typed "$shell" "ricochet branches $folder/mi" "$folder/mine.ricochet"
    tmux -S "$folder/tmux" kill-session -t "$shell"
done
! command -v tmux >/dev/null || tmux -S "$folder/tmux" kill-server
wrong() { "$ricochet" --completion tcsh 2>"$folder/out"; [ $? = 2 ] && grep -q 'there are bash, zsh and fish' "$folder/out"; }
ok 'another shell' wrong
finish
