/* Models of two masses that several tests make studies of; `explore` is theirs. */
#ifndef STUDIES_H
#define STUDIES_H

#define TWO_MASSES                                                                                 \
    "title: two masses\nmodel:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n"       \
    "  contacts:\n    - {name: stop, normal: [-1, 1], clearance: 1.0, sides: both, law: rigid}\n"
#define LOOSE_MASS                                                                                 \
    "title: loose mass\nmodel:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[8, 0], [0, 0]]\n"         \
    "  contacts:\n    - {normal: [-1, 1], clearance: 0.7, sides: both, law: rigid}\n"
#define TWO_WALLS                                                                                  \
    "title: two walls\nmodel:\n  mass: [[1, 0], [0, 1.3]]\n  stiffness: [[3, -1], [-1, 2.2]]\n  "  \
    "contacts:\n"                                                                                  \
    "    - {name: a, normal: [1, 0], clearance: 1.0, sides: upper, law: rigid}\n"                  \
    "    - {name: b, normal: [0, 1], clearance: 0.8, sides: lower, law: rigid}\n"

#endif
