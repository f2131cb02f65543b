/* Runs a target over files instead of libFuzzer, and needs nothing of clang: driver FILE... Prints TAP. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size);

/* Exactly as many bytes as the file has, so that the address sanitizer sees what is read beyond them. */
static uint8_t* read_file(const char* path, size_t* size) {
    FILE* file = fopen(path, "rb");
    uint8_t* bytes = NULL;
    long length;
    if (!file) return NULL;
    if (fseek(file, 0, SEEK_END) == 0 && (length = ftell(file)) >= 0 && fseek(file, 0, SEEK_SET) == 0) {
        *size = (size_t)length;
        bytes = (uint8_t*)malloc(*size ? *size : 1);
        if (bytes && fread(bytes, 1, *size, file) != *size) {
            free(bytes);
            bytes = NULL;
        }
    }
    fclose(file);
    return bytes;
}

int main(int count, char** paths) {
    int i;
    printf("1..%d\n", count - 1);
    for (i = 1; i < count; ++i) {
        size_t size = 0;
        uint8_t* bytes = read_file(paths[i], &size);
        fflush(stdout);
        if (bytes) LLVMFuzzerTestOneInput(bytes, size);
        printf("%s %d - %s\n", bytes ? "ok" : "not ok", i, paths[i]);
        free(bytes);
    }
    return 0;
}
