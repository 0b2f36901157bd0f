/* Read before every file of this folder (CMakeLists.txt: -include), so that the copies stay as musl has them.
 * Gives every function of musl the prefix espalier_musl_, because the C library has functions of these names too.
 * Turns the branches with fused multiply-add off: without them all processors compute the same bits. */
#ifndef ESPALIER_MUSL_PREFIX_H
#define ESPALIER_MUSL_PREFIX_H

/* the C library's declarations come first, under their own names */
#include <features.h>
#include <float.h>
#include <math.h>
#include <stdint.h>

#undef __FP_FAST_FMA
#define __FP_FAST_FMA 0

#define hidden __attribute__((__visibility__("hidden")))

#define acos espalier_musl_acos
#define asin espalier_musl_asin
#define atan espalier_musl_atan
#define cos espalier_musl_cos
#define exp espalier_musl_exp
#define exp2 espalier_musl_exp2
#define expm1 espalier_musl_expm1
#define log espalier_musl_log
#define log10 espalier_musl_log10
#define log1p espalier_musl_log1p
#define log2 espalier_musl_log2
#define pow espalier_musl_pow
#define scalbn espalier_musl_scalbn
#define sin espalier_musl_sin
#define tan espalier_musl_tan

#define __cos espalier_musl_cos_kernel
#define __exp_data espalier_musl_exp_data
#define __log2_data espalier_musl_log2_data
#define __log_data espalier_musl_log_data
#define __math_divzero espalier_musl_divzero
#define __math_invalid espalier_musl_invalid
#define __math_oflow espalier_musl_oflow
#define __math_uflow espalier_musl_uflow
#define __math_xflow espalier_musl_xflow
#define __pow_log_data espalier_musl_pow_log_data
#define __rem_pio2 espalier_musl_rem_pio2
#define __rem_pio2_large espalier_musl_rem_pio2_large
#define __sin espalier_musl_sin_kernel
#define __tan espalier_musl_tan_kernel

/* declared again under their new names: a function without a declaration would return an int */
double acos(double);
double asin(double);
double atan(double);
double cos(double);
double exp(double);
double exp2(double);
double expm1(double);
double log(double);
double log10(double);
double log1p(double);
double log2(double);
double sin(double);
double tan(double);
double pow(double, double);
double scalbn(double, int);

/* only declared: the C library declares functions of these names otherwise */
#define __cosl espalier_musl_cosl_kernel
#define __sinl espalier_musl_sinl_kernel
#define __tanl espalier_musl_tanl_kernel

#endif
