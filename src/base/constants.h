/* Numbers of mathematics, to more digits than any type has. */
#ifndef RIC_BASE_CONSTANTS_H
#define RIC_BASE_CONSTANTS_H

#define RIC_PI 3.14159265358979323846
#define RIC_TWO_PI 6.28318530717958647693
/* RIC_TWO_PI_LONG: where long double is computed in */
#define RIC_TWO_PI_LONG 6.28318530717958647692528676655900577L

#endif
