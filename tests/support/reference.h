/* The full-screen passes once more, in double precision and a pixel at a time: what the shaders' output is
   compared with. Runs on a packed G-buffer read back from the device. Written from the equations (paper,
   Equations 1, 2, 4, 5; the comments of deepgbuffer.h), not from the shaders. Only the placement of the taps
   is float arithmetic, so that they land on the same texels. Every result comes with the error that float
   arithmetic may have made on the way. */
#ifndef REFERENCE_H
#define REFERENCE_H

#include "deepgbuffer.h"

#define REFERENCE_EPSILON 5.9604644775390625e-8 /* half an ulp of a float in 1..2: the unit of every error */

typedef struct reference { /* the packed shading input */
    int width, height, layers, levels;
    int divisor;                        /* of layer 1's resolution */
    float* z[DGB_MAX_LEVELS];           /* `layers` a texel */
    float* normals[DGB_MAX_LEVELS];     /* 2 * layers a texel: bytes over 255 */
    float* radiance[2][DGB_MAX_LEVELS]; /* 3 a texel; null: none */
    double projection[16];              /* widened and jittered */
    dgb_camera camera;                  /* for tap placement only */
} reference;

/* Copies level 0 (radiance[l] may be null) and makes the other levels by the copy rule. */
void reference_open(reference* r, const dgb_context* context, const float* z, const float* normals,
                    const float* const radiance[2]);
void reference_close(reference* r);

/* Width or height of a level. */
int reference_size(int size, int level);

typedef struct reference_ao {
    double sum, error; /* of the taps' terms, and what floats may be off */
    double reach;      /* pixels */
    bool empty;        /* no surface */
} reference_ao;

reference_ao reference_occlusion(const reference* r, const dgb_params* q, int x, int y);
/* Ambient visibility for a sum of terms. */
double reference_visibility(const reference_ao* ao, const dgb_params* q, double sum);

typedef struct reference_light {
    double low[3], high[3]; /* irradiance */
    double low_confidence, high_confidence;
    int doubtful; /* senders so close to the receiver's plane that rounding decides whether they count */
    bool unsure;  /* rounding decides about a sender that matters: no telling */
} reference_light;

reference_light reference_irradiance(const reference* r, const dgb_params* q, dgb_senders senders,
                                     dgb_normaliser normaliser, int x, int y);

typedef struct reference_filtered {
    double value[4], error[4];
} reference_filtered;

/* One direction (axis 0: along x) of the reconstruction of an image of `channels` floats a texel; only texels
   inside rect (x0, y0, x1, y1, inclusive) count. */
reference_filtered reference_reconstruct(const reference* r, const dgb_params* q, int axis, const int rect[4],
                                         const float* image, int channels, int x, int y);

#endif
