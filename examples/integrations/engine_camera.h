/* The picture of the integrations, and where it is taken from. */
#ifndef ENGINE_CAMERA_H
#define ENGINE_CAMERA_H

enum { ENGINE_WIDTH = 960, ENGINE_HEIGHT = 540 };

/* By columns: 3 m up, 7 m back, looking 18 degrees down; 50 degrees high; 0.1 to 100 m. */
#define ENGINE_VIEW \
    { 1, 0, 0, 0, 0, 0.951f, 0.309f, 0, 0, -0.309f, 0.951f, 0, 0, -0.69f, -7.58f, 1 }
#define ENGINE_PROJECTION \
    { 1.20628125f, 0, 0, 0, 0, 2.1445f, 0, 0, 0, 0, -1.002f, -1, 0, 0, -0.2002f, 0 }

#endif
