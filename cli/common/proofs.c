/* What is proved of an atlas, by the proofs that are kept with it. */
#include <stdio.h>

#include "cli.h"

bool cli_count_proofs(const ric_atlas *atlas, cli_proofs *out)
{
    *out = (cli_proofs){.why = ""};
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_branch branch;
        ric_curve_proof curve;
        ric_proof proof;
        if (ric_atlas_branch(atlas, id, &branch)) continue;
        out->points += branch.n_point;
        out->points_proved += branch.n_proved;
        out->curves += branch.letters > 0;
        out->curves_proved += branch.curve_proved;
        out->tried += ric_curve_proof_kept(atlas, id, &curve);
        for (int i = 0; i < branch.n_point; i++) {
            if (!ric_proof_kept(atlas, id, i, &proof, NULL)) continue;
            out->tried++;
            if (proof.state == RIC_PROOF_LEFT_OUT)
                snprintf(out->why, sizeof out->why, "%s", proof.why);
        }
    }
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        ric_junction junction;
        ric_junction_proof proof;
        if (ric_atlas_junction(atlas, id, &junction) || junction.kind == RIC_KIND_START ||
            junction.kind == RIC_KIND_USER)
            continue;
        out->junctions++;
        out->junctions_proved += junction.proved;
        out->tried += ric_junction_proof_kept(atlas, id, &proof);
    }
    return out->tried > 0;
}

void cli_write_proofs(const cli_proofs *p, char *text, size_t size)
{
    snprintf(text, size, "%d of %d points, %d of %d curves, %d of %d junctions", p->points_proved,
             p->points, p->curves_proved, p->curves, p->junctions_proved, p->junctions);
}
