      PROGRAM BITS
C     PRINTS EVERY NUMBER OF EACH STATE IN ALL ITS DIGITS
      INTEGER MN, MQ
      PARAMETER (MN=200, MQ=3)
      INCLUDE 'flankload.inc'
      INTEGER NPROB, IPROB, N, NQ, ISTRUC, METHOD, INFO, I
      INTEGER KACT(MN), KCOUNT(5), KWARM(1)
      DOUBLE PRECISION FK(MN*MN), G0(MN), B(MN*MQ), R(MN*MQ), Q(MQ)
      DOUBLE PRECISION F(MN), G(MN), S(MQ), T(MQ*MQ), C(5)
      READ (5,*) NPROB
      DO 10 IPROB = 1, NPROB
         READ (5,*) N, NQ, ISTRUC, METHOD
         READ (5,*) (FK(I), I = 1, N*N)
         READ (5,*) (G0(I), I = 1, N)
         READ (5,*) (B(I), I = 1, N*NQ)
         READ (5,*) (R(I), I = 1, N*NQ)
         READ (5,*) (Q(I), I = 1, NQ)
         CALL FLANKLOAD_SOLVE_CONTACT (N, NQ, 0, FK, G0, B, R, Q,
     &        ISTRUC, METHOD, KWARM, F, G, S, T, KACT, KCOUNT, C, INFO)
         WRITE (6,20) INFO, KCOUNT(1), (F(I), I = 1, N),
     &        (G(I), I = 1, N), (S(I), I = 1, NQ),
     &        (T(I), I = 1, NQ*NQ), (C(I), I = 1, 5)
   20    FORMAT (2I8, 10000(1X, ES25.17E3))
   10 CONTINUE
      END
